#version 460
// VplShadowMaps::build(): a thread a texel.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define COUNTERS_BINDING 0
#include "renderer/backends/gpu/counters.glsl"
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/many_lights/vpl_shadow_maps.glsl"
#include "renderer/many_lights/vpl_shared.h"
#include "renderer/transport/surface.glsl"

layout(local_size_x = VPL_MAP_GROUP) in;
layout(push_constant, scalar) uniform Push { VplMapPush push; };
layout(set = 0, binding = 1, scalar) readonly buffer Vpls { Vpl vpls[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Counts { uint counts[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer Maps { float reach_m[]; };

void main() {
    const uint texels = push.resolution * push.resolution;
    const uint light = flat_index() / texels, texel = flat_index() % texels;
    if (light >= min(counts[push.count_word], push.most_lights)) return;
    const Frame axes = make_frame(vpls[light].normal);
    const vec3 direction = to_world(axes, vpl_map_texel_direction(texel, push.resolution));
    const Hit hit = closest_hit(Ray(offset_ray_origin(vpls[light].position, axes.normal), direction, INFINITY));
    float reach = INFINITY;
    if (hit_valid(hit)) {
        const vec3 normal = make_plain_shading_point(hit, direction).geometric_normal;
        reach = vpl_map_reach(texel, push.resolution, hit.t, to_local(axes, normal));
    }
    reach_m[flat_index()] = reach;
    count(COUNTER_SHADOW_RAYS, 1u);
}
