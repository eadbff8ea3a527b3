#version 460
// Points lit by virtual point lights: the lights of its tile's subset, summed over by a point, a thread a point. CPU
// twin VplLighting::light(). Compiled once for each way to answer V (vpl_visibility.glsl).
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#define COUNTERS_BINDING 0
#include "renderer/backends/gpu/counters.glsl"
#define VPL_LOBES_BINDING 6
#include "renderer/many_lights/vpl_lighting.glsl"

layout(local_size_x = SPLIT_GROUP) in;
layout(push_constant, scalar) uniform Push { VplLightingPush push; };
layout(set = 0, binding = 1, scalar) readonly buffer Constants { VplLightingConstants constants; };
layout(set = 0, binding = 2, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 3, scalar) readonly buffer GeneralPoints { GBufferGeneral general_points[]; };
layout(set = 0, binding = 4, scalar) readonly buffer Counts { uint counts[VPL_COUNT_WORDS]; };
layout(set = 0, binding = 5, scalar) readonly buffer Vpls { Vpl vpls[]; };
layout(set = 0, binding = 7, scalar) buffer Sums { vec3 sums[]; };
#include "renderer/many_lights/vpl_roulette.glsl"
#include "renderer/many_lights/vpl_visibility.glsl"

uint shadow_queries = 0;

/// The lights' sum, n^2-fold: each stands for those of the other subsets.
vec3 sum_of_lights(GBufferPoint point, Receiver receiver, uint first, uint end, uint tiles) {
    float total = 0.0, lit = 0.0;
    if (constants.roulette > 0.0 && vpl_visibility_asks()) {
        for (uint i = first; i < end; i += tiles) {
            const float size = max_component(vpl_light(vpls[i], point, receiver, constants.clamp_sq_m2));
            total += size;
            lit += size > 0.0 ? 1.0 : 0.0;
        }
        if (lit == 0.0) return vec3(0.0);
    }
    const VplRoulette roulette = vpl_roulette(point, total, lit);
    vec3 sum = vec3(0.0);
    for (uint i = first; i < end; i += tiles) {
        const Vpl vpl = vpls[i];
        const vec3 light = vpl_light(vpl, point, receiver, constants.clamp_sq_m2);
        const float chance = asked_chance(roulette, max_component(light), i);
        if (chance == 0.0) continue;
        if (vpl_visibility_asks()) ++shadow_queries;
        if (!vpl_occluded(i, vpl, point)) sum += light * (float(tiles) / chance);
    }
    return sum;
}

void main() {
    const uint index = push.first_point + flat_index();
    if (index < push.end_point) {
        const GBufferPoint point = points[index];
        if (is_lit(point)) {
            Receiver receiver;
            if (is_general(point)) receiver = make_receiver(general_points[index], constants.glossy_threshold);
            const uint tiles = constants.split.side * constants.split.side;
            const uint subset = (split_tile_of(constants.split, index) + constants.rotation) % tiles;
            const uint end = min(subset + push.end_light * tiles, counts[VPL_COUNT]);
            sums[index] += sum_of_lights(point, receiver, subset + push.first_light * tiles, end, tiles);
        }
        count(COUNTER_SHADOW_RAYS, shadow_queries);
    }
}
