#version 460
// Points lit by texels about their own places in the lights' maps, a thread a point. [Dachsbacher and Stamminger 2005]
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define TEXEL_RUNS_BINDING 3
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/methods/reflective_shadow_maps/rsm_projection.glsl"
#include "renderer/methods/reflective_shadow_maps/rsm_shared.h"
#include "renderer/many_lights/vpl_lighting.glsl"
#include "renderer/photons/reflected_photon_shared.h"
#include "renderer/photons/texel_map.glsl"

layout(local_size_x = RSM_GROUP) in;
layout(push_constant, scalar) uniform Push { RsmGatherPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 1, scalar) readonly buffer GeneralPoints { GBufferGeneral general_points[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Texels { ReflectedPhotonRecord texels[]; };
layout(set = 0, binding = 4, scalar) buffer Sums { vec3 sums[]; };

/// What a texel brings.
vec3 texel_light(ReflectedPhotonRecord texel, GBufferPoint point, Receiver receiver) {
    if (is_black(texel.power_w)) return vec3(0.0);
    const Vpl vpl = Vpl(texel.position, 1.0, texel.normal, 0u, texel.power_w * INV_PI, NO_VPL_SURFACE, 1u, 0.0);
    const VplConnection connection = connect_vpl(vpl, point, push.clamp_sq_m2);
    if (!(connection.gain > 0.0)) return vec3(0.0);
    const vec3 light = vpl.intensity * connection.gain;
    if (is_general(point))
        return light * bsdf_f_cos(receiver.rough, receiver.wo, to_local(receiver.surface.shading, connection.to_light));
    return light * connection.cos_x;
}

/// Where a sample is in the light's square, and its weight: 0 past the border.
vec2 sample_place(RsmProjection at, vec2 u, out float weight) {
    weight = 1.0;
    if (!at.local) return u;
    const vec2 sc = sin_cos(2.0 * PI * u.y);
    vec2 place = at.place + push.sample_radius * u.x * vec2((at.high - at.low) * sc.y, sc.x);
    if (at.around) place.y = fract(place.y);
    const bool inside = place.x >= at.low && place.x < at.high && place.y >= 0.0 && place.y < 1.0;
    weight = inside ? u.x * u.x : 0.0;
    return clamp(place, vec2(0.0), vec2(BELOW_ONE));
}

/// All texels of a light, those of one side of it where it has two, as its samples have it.
vec3 light_of_run(TexelRun run, uint first, uint end, GBufferPoint point, Receiver receiver, vec2 rotation) {
    const RsmProjection at = project_to_light(run.light, point.position);
    vec3 sum = vec3(0.0);
    float weights = 0.0;
    for (uint i = first; i < end; ++i) {
        // Multiples of the plastic number's powers [Roberts 2018], in fractions of 2^32.
        const vec2 u = fract(rotation + vec2(to_unit_float(i * 0xc13fa9a9u), to_unit_float(i * 0x91e10da5u)));
        float weight;
        const vec2 place = sample_place(at, u, weight);
        weights += weight;
        if (weight > 0.0)
            sum += weight * texel_light(texels[run.first_texel + texel_at_place(place, run.texels)], point, receiver);
    }
    return weights > 0.0 ? sum * ((at.high - at.low) * float(run.texels) / weights) : vec3(0.0);
}

void main() {
    const uint index = push.first_point + flat_index();
    if (index >= push.end_point) return;
    const GBufferPoint point = points[index];
    if (!is_lit(point)) return;
    Receiver receiver;
    if (is_general(point)) receiver = make_receiver(general_points[index], push.glossy_threshold);
    const uint key = hash32(point.pixel ^ push.key);
    const vec2 rotation = vec2(to_unit_float(hash32(key)), to_unit_float(hash32(key + 1u)));
    const float offset = to_unit_float(hash32(key + 2u));
    const TexelRun last = texel_runs[push.runs - 1u];
    const float samples_a_texel = float(push.samples) / float(last.first_texel + last.texels);
    vec3 light = vec3(0.0);
    for (uint i = 0; i < push.runs; ++i) {
        const TexelRun run = texel_runs[i];
        // Sample s belongs to the light that has the texel of place s + offset.
        const float share = float(run.texels) * samples_a_texel;
        const float begin = float(run.first_texel) * samples_a_texel + offset;
        const uint first = uint(ceil(begin)), end = uint(ceil(begin + share));
        if (end > first) light += light_of_run(run, first, end, point, receiver, rotation) / min(share, 1.0);
    }
    sums[index] += light;
}
