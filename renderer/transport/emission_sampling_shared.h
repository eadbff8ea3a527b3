// Where light paths start, for both compilers.
#ifndef PHOTOND_EMISSION_SAMPLING_SHARED_H
#define PHOTOND_EMISSION_SAMPLING_SHARED_H

// Photons from outside start this many radii before the scene's centre, so that nothing lies behind them.
#define EMISSION_START_IN_RADII 1.01f

#endif
