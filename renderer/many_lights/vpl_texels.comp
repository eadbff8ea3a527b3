#version 460
// What the texels of the lights' map see, a thread a texel. CPU twin: seen_texels.cpp.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define COUNTERS_BINDING 0
#define TEXEL_RUNS_BINDING 4
#include "renderer/backends/gpu/counters.glsl"
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/photons/photon.glsl"
#include "renderer/photons/photon_paths.glsl"
#include "renderer/photons/reflected_photon_shared.h"
#include "renderer/photons/texel_map.glsl"
#include "renderer/many_lights/vpl_tracer_shared.h"

layout(local_size_x = VPL_GROUP) in;
layout(push_constant, scalar) uniform Push { VplTexelsPush push; };
layout(set = 0, binding = 1, scalar) buffer State { uint state[REFLECTION_STATE_WORDS]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Texels { ReflectedPhotonRecord texels[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer Flux { float flux_w[]; };

const ReflectedPhotonRecord NOTHING_SEEN = ReflectedPhotonRecord(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), 0u, 1.0,
                                                                 NO_SURFACE, 1u | SPREAD_BEAM << SPREAD_SHIFT);

/// The greatest component of what a path may carry on from there [W]; 0: there is nothing.
float see(uint texel, out ReflectedPhotonRecord photon) {
    photon = NOTHING_SEEN;
    EmissionSample start;
    PhotonPath path;
    if (!start_at_texel(texel, push.runs, push.sequence, start) || !start_photon_path(start, 1.0, path)) return 0.0;
    count(COUNTER_PHOTON_RAYS, 1);
    Hit hit;
    PhotonVertex vertex;
    if (!follow_photon(path, start.ray, start.range_m, hit) ||
        !part_hit(path, hit, start.ray.direction, push.connect_threshold, vertex))
        return 0.0;
    const bool plain = is_plain_lambert(vertex.point.material);
    const bool stays = plain || (bsdf_scatters(vertex.rough) && !bsdf_has_non_delta_transmission(vertex.rough));
    float flux = 0.0;
    uint spread = SPREAD_BEAM;
    vec3 reflected_w = vec3(0.0);
    if (plain) {
        reflected_w = path.power_w * vertex.rough.diffuse;
        if (!is_sound(reflected_w)) return 0.0;
        flux = max_component(reflected_w);
        spread = SPREAD_LAMBERT;
    } else {
        if (stays) {
            const vec3 albedo = bsdf_albedo(vertex.rough);
            reflected_w = path.power_w * albedo;
            flux = flux_to_keep_by(path.power_w, albedo);
            spread = bsdf_is_lambert(vertex.rough) ? SPREAD_LAMBERT : SPREAD_ROUGH;
        }
        if (push.bounces > 1) {
            if (bsdf_scatters(vertex.specular)) flux += flux_to_keep_by(path.power_w, bsdf_albedo(vertex.specular));
            if (bsdf_scatters(vertex.rough) && !stays)
                flux += flux_to_keep_by(path.power_w, bsdf_albedo(vertex.rough));
        }
    }
    if (!(flux > 0.0)) return 0.0;
    photon.position = vertex.point.position;
    photon.power_w = reflected_w;
    photon.normal = photon.direction = vertex.point.geometric_normal;
    photon.smooth_normal = octahedral_encode(16u, vertex.point.smooth_normal);
    photon.scatterings_and_spread = 1u | spread << SPREAD_SHIFT;
    return flux;
}

void main() {
    const uint texel = flat_index();
    if (texel >= push.texels) return;
    ReflectedPhotonRecord photon = NOTHING_SEEN;
    flux_w[texel] = texel < push.used_texels ? see(texel, photon) : 0.0;
    texels[texel] = photon;
    if (photon_nan_samples > 0) atomicAdd(state[REFLECTION_NAN_SAMPLES], photon_nan_samples);
    if (photon_infinite_samples > 0) atomicAdd(state[REFLECTION_INFINITE_SAMPLES], photon_infinite_samples);
}
