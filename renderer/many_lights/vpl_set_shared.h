// The lights of a pass on a device (vpl_set_gpu.h), for both compilers.
#ifndef PHOTOND_VPL_SET_SHARED_H
#define PHOTOND_VPL_SET_SHARED_H

#include "renderer/many_lights/vpl_shared.h"

#define VPL_SET_GROUP 64  // threads

#define VPL_SHOWN_DEPTH 0.01f  // a pixel shows a light whose depth differs from its own by that share at the most

// Words of the pass's counts.
#define VPL_COUNT 0  // virtual point lights
#define VPL_COUNT_WORDS 4

#ifdef __cplusplus
namespace photond::gpu {
#endif

/// RoughOrigin: what light is reflected by at a light that is not Lambert, at Vpl::surface. Rough and reflecting alone,
/// so no more of a Bsdf than that; the geometric normal is the light's.
struct VplLobes {
    vec3 smooth_normal;  // unit
    vec3 wi_world;       // unit, towards where the light came from
    uint flags;
    vec3 diffuse;
    float alpha;
    float table_row;
    vec3 specular_f0;
    float specular_f90;
    float coat_f0;
    float coat_f90;
};

/// Photons become lights, a thread each.
struct VplGatherPush {
    uint most;                // lights and lobes that there is room for
    float connect_threshold;  // lobes with GGX alpha below it send nothing
};

#ifdef __cplusplus
static_assert(sizeof(VplLobes) == 72 && sizeof(VplGatherPush) == 8, "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
