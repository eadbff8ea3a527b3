// Lighting a G-buffer by virtual point lights on a device, for both compilers.
#ifndef PHOTOND_VPL_LIGHTING_SHARED_H
#define PHOTOND_VPL_LIGHTING_SHARED_H

#include "renderer/gbuffer/split_shared.h"

// VplVisibility
#define VPL_VISIBILITY_SVO 0u
#define VPL_VISIBILITY_RAYS 1u
#define VPL_VISIBILITY_MAPS 2u
#define VPL_VISIBILITY_NONE 3u
#define VPL_VISIBILITY_NEAR_FIELD 4u

// Least chance of a light to be asked for V where the receiver is not Lambert: the cosines say less of what it brings.
#define VPL_LEAST_GENERAL_CHANCE 0.25f

// Specialisation constants, after those of device_image_shared.h.
#define CLAMP_IS_REPAID_ID 48       // what the clamp takes is added to the points' sums
#define CLAMP_IS_ASKED_ID 49        // it is looked for
#define NARROW_IS_ASKED_ID 50       // and what narrow lobes send
#define CAUSTICS_ARE_PHOTONS_ID 51  // lights do not count behind specular scatterings

// What shaders that ask for V bind it at, after all else (vpl_visibility_*.glsl).
#define VPL_VISIBILITY_BINDING 24

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
    float roulette;           // a light dimmer than that share of the mean is asked by chance; 0: all are
    float glossy_threshold;   // of eye paths
    float connect_threshold;  // of lights: lobes with GGX alpha below it send nothing
    uint map_resolution;      // VPL_VISIBILITY_MAPS
    float voxel_reach_m;      // voxels farther from a point do not stand in its light
};

/// Points, a thread each, and lights of their tile's subset, by their place in it; both half open.
struct VplLightingPush {
    uint first_point;
    uint end_point;
    uint first_light;
    uint end_light;
};

#ifdef __cplusplus
static_assert(sizeof(VplLightingConstants) == 64, "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
