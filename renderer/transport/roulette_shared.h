// Russian roulette of all paths, for both compilers.
#ifndef PHOTOND_ROULETTE_SHARED_H
#define PHOTOND_ROULETTE_SHARED_H

// Surface interactions after which roulette may end a path from the eye, where no parameter says otherwise.
#define ROULETTE_START 4u
// No path outlives roulette for ever, however white the scene.
#define ROULETTE_MOST_SURVIVAL 0.98f

#endif
