#version 460
// Lights drawn for each point in proportion to what they would bring unshadowed: ResampledVpls::choose().
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/many_lights/vpl_choice_shared.h"
#include "renderer/many_lights/vpl_lighting.glsl"

layout(local_size_x = SPLIT_GROUP) in;
layout(push_constant, scalar) uniform Push { VplChoicePush push; };
layout(set = 0, binding = 1, scalar) readonly buffer Constants { VplLightingConstants constants; };
layout(set = 0, binding = 2, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 4, scalar) readonly buffer Counts { uint counts[VPL_COUNT_WORDS]; };
// Two vectors a light: position and vpl_size(); normal and scatterings, which are negative where it is not Lambert.
layout(set = 0, binding = 5, std430) readonly buffer ChoiceLights { vec4 choice_lights[]; };
layout(set = 0, binding = CHOSEN_BINDING, scalar) writeonly buffer Chosen { ChosenVplRecord chosen[]; };
layout(set = 0, binding = CHOSEN_COUNTS_BINDING, scalar) writeonly buffer ChosenCounts { uint chosen_counts[]; };

const float LEAST_GENERAL_COSINE = 0.25;  // kLeastGeneralCosine

/// What a light is chosen by. `least_cosine`: at the point; 1 where light from both sides counts.
float size_of(uint light, GBufferPoint point, float most_scatterings, float least_cosine) {
    const vec4 at = choice_lights[2u * light], facing = choice_lights[2u * light + 1u];
    const vec3 d = at.xyz - point.position;
    const float d_sq = dot(d, d), along_light = -dot(facing.xyz, d), along_point = dot(point.normal, d);
    if (!(along_light > 0.0) || !(along_point > 0.0 || least_cosine == 1.0)) return 0.0;
    if (abs(facing.w) > most_scatterings) return 0.0;
    const float inverse_d = 1.0 / sqrt(max(d_sq, 1e-37));
    const float cos_light = facing.w > 0.0 ? along_light * inverse_d : 1.0;
    const float cos_point = least_cosine + (1.0 - least_cosine) * (along_point * inverse_d);
    return at.w * cos_light * cos_point / max(max(d_sq, constants.clamp_sq_m2), 1e-20);
}

void main() {
    const uint place = flat_index(), index = push.first_point + place;
    if (index >= push.end_point) return;
    const GBufferPoint point = points[index];
    uint found = 0;
    if (is_lit(point)) {
        const float least_cosine = point.normal == vec3(0.0) ? 1.0 : is_general(point) ? LEAST_GENERAL_COSINE : 0.0;
        const float most_scatterings = float(point.kind & GBUFFER_SCATTERINGS);
        const uint lights = counts[VPL_COUNT];
        float total = 0.0;
        for (uint group = 0; group < lights; group += RESAMPLED_GROUP_LIGHTS) {
            const uint end = min(group + RESAMPLED_GROUP_LIGHTS, lights);
            float sum = 0.0;
            for (uint i = group; i < end; ++i) sum += size_of(i, point, most_scatterings, least_cosine);
            total += sum;
        }
        const float start = to_unit_float(hash32(point_key(point, constants.seed, constants.pass) ^ RESAMPLED_SALT));
        const float step_size = total / float(push.most);
        float passed = 0.0, last_size = 0.0;
        uint last = 0, steps = 0;
        if (total > 0.0) {
            for (uint group = 0; group < lights && steps < push.most; group += RESAMPLED_GROUP_LIGHTS) {
                const uint end = min(group + RESAMPLED_GROUP_LIGHTS, lights);
                float sum = 0.0;
                for (uint i = group; i < end && steps < push.most; ++i) {
                    const float size = size_of(i, point, most_scatterings, least_cosine);
                    if (!(size > 0.0)) continue;
                    sum += size;
                    last = i;
                    last_size = size;
                    const uint before = steps;
                    while (steps < push.most && (float(steps) + start) * step_size < passed + sum) ++steps;
                    if (steps > before)
                        chosen[found++ * push.stride + place] =
                            ChosenVplRecord(i, float(steps - before) * step_size / size);
                }
                passed += sum;
            }
            // What rounding leaves over is the last light's.
            if (steps < push.most && last_size > 0.0)
                chosen[found++ * push.stride + place] =
                    ChosenVplRecord(last, float(push.most - steps) * step_size / last_size);
        }
    }
    chosen_counts[place] = found;
}
