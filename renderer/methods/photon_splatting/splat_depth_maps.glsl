// GLSL twin of methods/photon_splatting/splat_depth_maps.h: which points the light of a beam reaches. Includers say at
// which binding of set 0 the maps are: DEPTH_MAPS_BINDING.
#ifndef PHOTOND_SPLAT_DEPTH_MAPS_GLSL
#define PHOTOND_SPLAT_DEPTH_MAPS_GLSL

#include "renderer/core/geometry.glsl"
#include "renderer/methods/photon_splatting/splat_shared.h"

layout(set = 0, binding = DEPTH_MAPS_BINDING, scalar) readonly buffer DepthMaps { float farthest_m[]; };

/// Whether light along the splat's axis reaches the point at `d` from its origin, within its radius of the axis. The map
/// is the index-th, `side` texels wide.
bool reaches(uint index, uint side, Splat splat, vec3 d) {
    const Frame frame = make_frame(splat.axis);
    const vec2 across = vec2(dot(d, frame.tangent), dot(d, frame.bitangent));
    // Points on the border too.
    const uvec2 texel = uvec2(clamp(across * (0.5 * float(side) / splat.radius) + 0.5 * float(side), 0.0, float(side - 1)));
    return dot(d, splat.axis) - splat.near_m <= farthest_m[(index * side + texel.y) * side + texel.x];
}

#endif
