// The queues of wavefronts of paths from the eye, for both compilers.
#ifndef PHOTOND_WAVE_QUEUES_SHARED_H
#define PHOTOND_WAVE_QUEUES_SHARED_H

#define WAVE_GROUP 64  // threads

// What waits: paths under way; shadow rays; and vertices that are joined with others.
#define WAVE_PATHS 0
#define WAVE_SHADOWS 1
#define WAVE_JOINS 2
#define WAVE_QUEUES 3

// Words of a queue: how many are there now, how many come next, and the groups of the dispatch over those there now.
#define WAVE_NOW(queue) (8 * (queue))
#define WAVE_NEXT(queue) (8 * (queue) + 1)
#define WAVE_GROUPS(queue) (8 * (queue) + 4)  // three words
#define WAVE_COUNT_WORDS (8 * WAVE_QUEUES)

#endif
