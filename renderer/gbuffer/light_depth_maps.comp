#version 460
// Depth maps of the scene's punctual lights, a texel a thread. CPU twin: LightDepthMaps.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/bvh.glsl"
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/gbuffer/light_depth_map.glsl"

layout(local_size_x = LIGHT_DEPTH_GROUP) in;
layout(push_constant, scalar) uniform Push { LightDepthPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Constants { LightDepthConstants constants; };
layout(set = 0, binding = 1, scalar) readonly buffer Maps { LightDepthMap maps[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Depths { float depths_m[]; };

/// The map that a texel belongs to: the last that begins at it or before.
uint map_of(uint texel) {
    uint low = 0, high = constants.maps;
    while (high - low > 1) {
        const uint middle = (low + high) / 2;
        if (maps[middle].first_texel <= texel) low = middle; else high = middle;
    }
    return low;
}

void main() {
    const uint texel = push.first_texel + flat_index();
    if (texel >= push.end_texel) return;
    const LightDepthMap map = maps[map_of(texel)];
    depths_m[texel] = closest_hit(light_depth_ray(map, constants.resolution, texel - map.first_texel)).t;
}
