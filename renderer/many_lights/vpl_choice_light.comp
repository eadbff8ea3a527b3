#version 460
// Points lit by the lights that were chosen for them, a thread a point. CPU twin VplLighting::light_by(). Compiled once
// for each way to answer V (vpl_visibility.glsl).
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#define COUNTERS_BINDING 0
#include "renderer/backends/gpu/counters.glsl"
#define VPL_LOBES_BINDING 6
#include "renderer/many_lights/vpl_choice_shared.h"
#include "renderer/many_lights/vpl_lighting.glsl"

layout(local_size_x = SPLIT_GROUP) in;
layout(push_constant, scalar) uniform Push { VplChoicePush push; };
layout(set = 0, binding = 1, scalar) readonly buffer Constants { VplLightingConstants constants; };
layout(set = 0, binding = 2, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 3, scalar) readonly buffer GeneralPoints { GBufferGeneral general_points[]; };
layout(set = 0, binding = 5, scalar) readonly buffer Vpls { Vpl vpls[]; };
layout(set = 0, binding = 7, scalar) buffer Sums { vec3 sums[]; };
layout(set = 0, binding = CHOSEN_BINDING, scalar) readonly buffer Chosen { ChosenVplRecord chosen[]; };
layout(set = 0, binding = CHOSEN_COUNTS_BINDING, scalar) readonly buffer ChosenCounts { uint chosen_counts[]; };
#include "renderer/many_lights/vpl_roulette.glsl"
#include "renderer/many_lights/vpl_visibility.glsl"

uint shadow_queries = 0;

vec3 light_of(ChosenVplRecord from, GBufferPoint point, Receiver receiver) {
    return from.weight * vpl_light(vpls[from.vpl], point, receiver, constants.clamp_sq_m2);
}

vec3 sum_of_chosen(uint place, GBufferPoint point, Receiver receiver) {
    const uint lights = chosen_counts[place];
    float total = 0.0, lit = 0.0;
    if (constants.roulette > 0.0 && vpl_visibility_asks()) {
        for (uint k = 0; k < lights; ++k) {
            const float size = max_component(light_of(chosen[k * push.stride + place], point, receiver));
            total += size;
            lit += size > 0.0 ? 1.0 : 0.0;
        }
        if (lit == 0.0) return vec3(0.0);
    }
    const VplRoulette roulette = vpl_roulette(point, total, lit);
    vec3 sum = vec3(0.0);
    for (uint k = 0; k < lights; ++k) {
        const ChosenVplRecord from = chosen[k * push.stride + place];
        const vec3 light = light_of(from, point, receiver);
        const float chance = asked_chance(roulette, max_component(light), from.vpl);
        if (chance == 0.0) continue;
        if (vpl_visibility_asks()) ++shadow_queries;
        if (!vpl_occluded(from.vpl, vpls[from.vpl], point)) sum += light / chance;
    }
    return sum;
}

void main() {
    const uint place = flat_index(), index = push.first_point + place;
    if (index < push.end_point) {
        const GBufferPoint point = points[index];
        if (is_lit(point)) {
            Receiver receiver;
            if (is_general(point)) receiver = make_receiver(general_points[index], constants.glossy_threshold);
            sums[index] += sum_of_chosen(place, point, receiver);
        }
        count(COUNTER_SHADOW_RAYS, shadow_queries);
    }
}
