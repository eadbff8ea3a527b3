// Depth maps of virtual point lights, for both compilers. C++: many_lights/vpl_shadow_maps.h, GLSL:
// vpl_shadow_maps.glsl.
#ifndef PHOTOND_VPL_SHADOW_MAPS_SHARED_H
#define PHOTOND_VPL_SHADOW_MAPS_SHARED_H

#define VPL_MAP_GROUP 64

#ifdef __cplusplus
#include <cstdint>
namespace photond::gpu {
using uint = uint32_t;
#endif

/// Of vpl_shadow_maps.comp.
struct VplMapPush {
    uint resolution;
    uint count_word;  // where the number of lights is
    uint most_lights;
};

#ifdef __cplusplus
}  // namespace photond::gpu
#endif

#endif
