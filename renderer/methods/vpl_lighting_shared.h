// Lighting a G-buffer by virtual point lights on a device, for both compilers.
#ifndef PHOTOND_VPL_LIGHTING_SHARED_H
#define PHOTOND_VPL_LIGHTING_SHARED_H

#include "renderer/gbuffer/split_shared.h"

// VplVisibility
#define VPL_VISIBILITY_SVO 0u
#define VPL_VISIBILITY_RAYS 1u
#define VPL_VISIBILITY_MAPS 2u
#define VPL_VISIBILITY_NONE 3u

// Specialisation constants, after those of device_image_shared.h.
#define VPL_VISIBILITY_ID 48

// Words of the pass's counts.
#define VPL_COUNT 0  // virtual point lights
#define VPL_COUNT_WORDS 4

#ifdef __cplusplus
namespace photond::gpu {
#else
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#endif

struct VplLightingConstants {
    uint64_t seed;
    uint pass;
    uint rotation;  // tile t takes the lights whose index is t + rotation modulo the number of tiles
    SplitRecord split;
    float clamp_sq_m2;        // B; 0: none
    float roulette;           // dimmer than that share of the mean so far: dropped by chance
    float glossy_threshold;   // of eye paths
    float connect_threshold;  // of lights: lobes with GGX alpha below it send nothing
};

#ifdef __cplusplus
}  // namespace photond::gpu
#endif

#endif
