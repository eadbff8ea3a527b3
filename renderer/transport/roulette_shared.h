// Russian roulette of all paths, for both compilers.
#ifndef PHOTOND_ROULETTE_SHARED_H
#define PHOTOND_ROULETTE_SHARED_H

// Surface interactions after which roulette may end a path from the eye, where no parameter says otherwise.
#define ROULETTE_START 4u
// The greatest probability by which roulette keeps a path: below 1, so that paths end however white the scene is.
#define ROULETTE_MOST_SURVIVAL 0.98f

#endif
