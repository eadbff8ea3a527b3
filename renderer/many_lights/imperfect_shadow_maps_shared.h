// Points instead of triangles in the depth maps of virtual lights, for both compilers (imperfect_shadow_maps.h).
#ifndef PHOTOND_IMPERFECT_SHADOW_MAPS_SHARED_H
#define PHOTOND_IMPERFECT_SHADOW_MAPS_SHARED_H

#define IMPERFECT_GROUP 64  // threads

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

/// A disc of a radius that all have.
struct OccluderPoint {
    vec3 position;  // world [m]
    vec3 normal;    // unit, either side; 0: there is none
};

/// Of imperfect_splat.comp.
struct ImperfectSplatPush {
    uint resolution;
    uint count_word;  // where the number of lights is
    uint first_light;
    uint end_light;
    uint points;  // that a light draws, one of each IMPERFECT_CHOICE neighbours
    uint key;     // of the pass's random numbers
    float radius_m;
};
#define IMPERFECT_CHOICE 16

/// Of imperfect_pull.comp and imperfect_push.comp: two neighbouring levels of the maps' pyramids.
struct ImperfectLevelPush {
    uint count_word;
    uint most_lights;
    uint fine_side;
    uint coarse_side;
};

#ifdef __cplusplus
static_assert(sizeof(OccluderPoint) == 24, "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
