// What shaders count, for both compilers.
#ifndef PHOTOND_COUNTERS_SHARED_H
#define PHOTOND_COUNTERS_SHARED_H

// Counters: 64 bits each as two words, low first, in the order of Counts (core/stats.h).
#define COUNTER_CAMERA_RAYS 0
#define COUNTER_BOUNCE_RAYS 1
#define COUNTER_SHADOW_RAYS 2
#define COUNTER_PHOTON_RAYS 3
#define COUNTER_PHOTONS_EMITTED 4
#define COUNTER_PHOTONS_STORED 5
#define COUNTER_SPLATS 6
#define COUNTER_SPLAT_CONTRIBUTIONS 7
#define COUNTERS 8

#endif
