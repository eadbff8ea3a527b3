// Direct light before its shadow (centre_shadows_gpu.h), for both compilers.
#ifndef PHOTOND_CENTRE_SHADOWS_SHARED_H
#define PHOTOND_CENTRE_SHADOWS_SHARED_H

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

#define NO_LAMP 0xffffffffu
#define LEAST_OCCLUDER_M 1e-30f  // what hides at once is not nothing

/// Of a pixel.
struct UnshadowedLight {
    vec3 position;     // of what the eye sees, world [m]
    float occluder_m;  // towards the middle of the light; 0: nothing is in between
    vec3 radiance;     // that comes to the eye where nothing is
    uint lamp;         // whose it is; NO_LAMP: no light waits for its shadow
};

#ifdef __cplusplus
static_assert(sizeof(UnshadowedLight) == 32);
}  // namespace photond::gpu
#endif

#endif
