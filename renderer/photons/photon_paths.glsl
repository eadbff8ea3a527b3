// GLSL twin of photons/photon_wavefront.h: light paths, from their emission over scattering after scattering, with the
// same numbers. A thread follows one path at a time; what is kept of it is the caller's (photon_tracing.comp keeps
// photons as they arrive).
//
// The twin shades plain Lambert reflectors apart, in lanes; here they go the way of all surfaces, which comes to the same
// but for rounding, and costs nothing where ONLY_LAMBERT leaves the rest out.
//
// Define GUIDE_WORDS_BINDING and GUIDE_FLOATS_BINDING (of set 0) before, where paths may start by a projection map, and
// PHOTON_LATER_HIT, the name of a function like closest_hit(), where it finds the hits after a path's first scattering.
#ifndef PHOTOND_PHOTON_PATHS_GLSL
#define PHOTOND_PHOTON_PATHS_GLSL

#include "renderer/backends/gpu/bvh.glsl"
#include "renderer/photons/photon_shared.h"
#include "renderer/transport/bsdf_material.glsl"
#include "renderer/transport/emission_sampling.glsl"
#include "renderer/transport/photon_scattering.glsl"
#include "renderer/transport/roulette_shared.h"
#include "renderer/transport/sobol.glsl"
#ifdef GUIDE_WORDS_BINDING
#include "renderer/photons/projection_map.glsl"
#endif

/// A path between two of its vertices: PhotonWavefront::Path.
struct PhotonPath {
    vec3 power_w;
    float reference_inverse;  // [1/W] of the greatest component at emission: roulette keeps the power near that
    uint scatterings;
    bool rough;  // has had a scattering that was not specular
    bool all_delta;
    MediumStack media;
};

/// A hit and the two parts of its BSDF: PhotonWavefront::PartedHit.
struct PhotonVertex {
    ShadingPoint point;
    vec3 wi_world;
    float outside_ior;
    Bsdf specular, rough;
};

/// The numbers of a scattering: sample_set(scatterings + 1, ScatteringSet) of photon_wavefront.h.
struct PhotonNumbers {
    vec2 direction;
    vec2 choice;  // roulette, and lobe
};

// What this thread found of powers that are not finite.
uint photon_nan_samples = 0, photon_infinite_samples = 0;

/// Whether power is fit to go on; counted where it is not finite.
bool is_sound(vec3 power_w) {
    if (is_finite(power_w)) return true;
    if (any(isnan(power_w)))
        ++photon_nan_samples;
    else
        ++photon_infinite_samples;
    return false;
}

/// `scatterings`: those before.
PhotonNumbers photon_numbers(SequenceKey sequence, uint64_t element, uint scatterings) {
    const uint first_set = 2 * scatterings + 3;
    return PhotonNumbers(sequence_sample_2d(sequence, element, scatterings == 0 ? 2 : first_set),
                         sequence_sample_2d(sequence, element, scatterings == 0 ? 4 : first_set + 1));
}

/// The first step of the path that has this element of the sequence: by the lights' power, or by the projection map. False:
/// it carries nothing.
bool draw_emission(SequenceKey sequence, uint64_t element, out EmissionSample start) {
    const float u_light = sequence_sample_2d(sequence, element, PHOTON_SET_LIGHT).x;
    const vec2 u_position = sequence_sample_2d(sequence, element, PHOTON_SET_POSITION);
    const vec2 u_direction = sequence_sample_2d(sequence, element, PHOTON_SET_DIRECTION);
#ifdef GUIDE_WORDS_BINDING
    if (guided()) return projection_map_sample(u_light, u_position, u_direction, start);
#endif
    return sample_emission(u_light, u_position, u_direction, start);
}

/// The path that starts so, with `share` of the power. False: it carries nothing.
bool start_photon_path(EmissionSample start, float share, out PhotonPath path) {
    path = PhotonPath(start.power_w * share, 0.0, 0u, false, true, make_medium_stack());
    if (is_black(start.power_w) || !is_sound(start.power_w)) return false;
    path.reference_inverse = 1.0 / max_component(path.power_w);
    return true;
}

const float LEAST_ROUGH_SHARE = 1.0 / 16;  // kLeastRoughShare

/// Of power reflected by lobes of that albedo.
float flux_to_keep_by(vec3 power_w, vec3 albedo) {
    return max(max_component(power_w * albedo), LEAST_ROUGH_SHARE * max_component(power_w));
}

/// is_plain_lambert() of lambert_lanes.h.
bool is_plain_lambert(uint material) {
    return ONLY_LAMBERT ||
           (scene_materials[material].metallic == 0.0 && scene_materials[material].specular == 0.0 &&
            scene_materials[material].transmission == 0.0 &&
            !texture_used(scene_materials[material].normal_texture));
}

/// Follows the ray to the next surface and takes what the way took from the path; `range_m` is that of the light, of first
/// rays alone. False: the path ends.
bool follow_photon(inout PhotonPath path, Ray ray, float range_m, out Hit hit) {
#ifdef PHOTON_LATER_HIT
    if (path.scatterings > 0)
        hit = PHOTON_LATER_HIT(ray);
    else
        hit = closest_hit(ray);
#else
    hit = closest_hit(ray);
#endif
    if (!hit_valid(hit)) return false;
    if (path.scatterings == 0 && range_m < INFINITY) path.power_w *= range_window(hit.t, range_m);
    path.power_w *= transmittance(path.media, hit.t);
    return !is_black(path.power_w);
}

/// False: nothing scatters there.
bool part_hit(PhotonPath path, Hit hit, vec3 ray_direction, float glossy_threshold, out PhotonVertex vertex) {
    vertex.wi_world = -ray_direction;
    vertex.point = make_shading_point(hit, ray_direction);
    vertex.outside_ior = 1.0;
    vertex.specular = vertex.rough = bsdf_nothing();
    const uint material = vertex.point.material;
    if (NEEDS_UNLIT && has_flag(scene_materials[material].flags, MATERIAL_UNLIT)) return false;
    vertex.outside_ior = medium_stack_outside_ior(path.media, material, !vertex.point.front_side);
    const Bsdf bsdf = make_bsdf(vertex.point, vertex.outside_ior);
    vertex.specular = bsdf_specular_part(bsdf, glossy_threshold);
    vertex.rough = bsdf_rough_part(bsdf, glossy_threshold);
    return true;
}

/// Sends the path on, by the rough part only if `by_rough`; `is_rough`: by that. False: it ends.
bool scatter_parted(PhotonVertex vertex, PhotonNumbers numbers, bool by_rough, inout PhotonPath path, inout Ray ray,
                    out bool is_rough) {
    is_rough = false;
    // Each part is tried; one number then chooses between them and absorption, by what they leave of the power.
    PhotonScattering specular = NO_PHOTON_SCATTERING, rough = NO_PHOTON_SCATTERING;
    if (!ONLY_LAMBERT && bsdf_scatters(vertex.specular))
        specular = scatter_photon(vertex.point, vertex.specular, vertex.wi_world, numbers.choice.y, numbers.direction);
    if (by_rough && bsdf_scatters(vertex.rough))
        rough = scatter_photon(vertex.point, vertex.rough, vertex.wi_world, numbers.choice.y, numbers.direction);
    const vec3 specular_w = path.power_w * specular.weight, rough_w = path.power_w * rough.weight;
    if (!is_sound(specular_w) || !is_sound(rough_w)) return false;
    const float specular_hope = max_component(specular_w) * path.reference_inverse;
    const float rough_hope = max_component(rough_w) * path.reference_inverse;
    const float hope = specular_hope + rough_hope;
    if (!(hope > 0.0)) return false;
    const float share = min(1.0, ROULETTE_MOST_SURVIVAL / hope);  // of the hope that is granted
    const float roulette = numbers.choice.x;
    if (roulette >= hope * share) return false;
    is_rough = roulette >= specular_hope * share;
    path.power_w = (is_rough ? rough_w : specular_w) / ((is_rough ? rough_hope : specular_hope) * share);
    if (!is_sound(path.power_w)) return false;
    const vec3 direction = is_rough ? rough.direction : specular.direction;
    path.rough = path.rough || is_rough;
    path.all_delta = path.all_delta && (is_rough ? rough.delta : specular.delta);
    if (is_rough ? rough.refraction : specular.refraction)
        medium_stack_cross(path.media, vertex.point.material, vertex.point.front_side);
    ++path.scatterings;
    ray = Ray(ray_origin(vertex.point, direction), direction, INFINITY);
    return true;
}

#endif
