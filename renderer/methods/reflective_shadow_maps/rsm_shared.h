// Points lit by texels of the lights' maps, for both compilers.
#ifndef PHOTOND_RSM_SHARED_H
#define PHOTOND_RSM_SHARED_H

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

#define RSM_GROUP 64  // threads

struct RsmGatherPush {
    uint first_point;  // half open
    uint end_point;
    uint runs;     // of texels
    uint samples;  // a point's, of all lights together
    uint key;      // of the pass's random numbers
    float sample_radius;
    float clamp_sq_m2;
    float glossy_threshold;
};

#ifdef __cplusplus
}  // namespace photond::gpu
#endif

#endif
