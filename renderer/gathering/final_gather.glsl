// GLSL twin of gathering/final_gather.h: rays from a point the eye sees, and the light that leaves the surfaces
// where they end. A thread follows one ray. Its path may part at its first end, into one by the specular and one by the rough
// part; the latter waits until the former has ended.
#ifndef PHOTOND_FINAL_GATHER_GLSL
#define PHOTOND_FINAL_GATHER_GLSL

#include "renderer/gathering/photon_lookup.glsl"
#include "renderer/transport/roulette_shared.h"

/// The direct light of a vertex, of which a ray that meets a light there is a sample.
struct SampledLight {
    vec3 position;  // of the vertex; with lit_normal as given to the light sampler
    vec3 lit_normal;
    float pdf_sa;  // of the ray's direction, times its rays over its light samples; 0: lights do not count
};
const SampledLight NO_SAMPLED_LIGHT = SampledLight(vec3(0.0), vec3(0.0), 0.0);

/// A gather ray between two of its vertices.
struct GatherPath {
    vec3 throughput;  // since the point
    float eta_scale;  // since the point, as in EyePath
    uint scatterings;
    uint vertex;  // number of the next one; the point's is 0
    SampledLight light;
    MediumStack media;
    Ray ray;
};

/// What rays find.
struct Gathered {
    vec3 direct, indirect;
    uint photons, rays, shadow_rays;
};

/// Radiance of a light that a ray met, and that a light sample where the ray began finds with that density.
void add_met_light(inout Gathered gathered, GatherPath path, vec3 radiance, float light_pdf) {
    const vec3 light = power_heuristic(path.light.pdf_sa, light_pdf) * path.throughput * radiance;
    if (path.scatterings == 1) gathered.direct += light; else gathered.indirect += light;
}

/// The ray's end: whether it meets a surface that scatters; what it sees of lights is added. `path` loses what the way
/// absorbed.
bool meet_end(inout GatherPath path, out Hit hit, out ShadingPoint surface, inout Gathered gathered) {
    ++gathered.rays;
    hit = closest_hit(path.ray);
    path.throughput *= transmittance(path.media, hit.t);
    if (!hit_valid(hit)) {
        if (NEEDS_ENVIRONMENT && path.light.pdf_sa > 0.0)
            add_met_light(gathered, path, environment_radiance(path.ray.direction),
                          light_pdf_environment(path.light.position, path.light.lit_normal, path.ray.direction));
        return false;
    }
    surface = make_shading_point(hit, path.ray.direction);
    if (NEEDS_UNLIT && has_flag(scene_materials[surface.material].flags, MATERIAL_UNLIT)) return false;
    if (NEEDS_AREA_LIGHTS && path.light.pdf_sa > 0.0 &&
        max_component(scene_materials[surface.material].emission) > 0.0) {
        const vec3 emitted = emitted_radiance(hit.instance, hit.triangle, hit.u, hit.v, surface.front_side);
        if (!is_black(emitted))
            add_met_light(gathered, path, emitted,
                          light_pdf_triangle(path.light.position, path.light.lit_normal, hit.instance, hit.triangle,
                                             path.ray.direction, hit.t));
    }
    return path.scatterings < eye.max_scatterings;
}

/// Goes on as sampled, unless Russian roulette with the number `roulette` ends the path; negative: it does not. Lights that
/// it meets do not count. False: it ended.
bool follow_gathered(inout GatherPath path, ShadingPoint surface, BsdfSample next, float roulette) {
    if (!bsdf_sample_valid(next)) return false;
    path.throughput *= next.weight;
    if (next.refraction) {
        path.eta_scale *= sqr(next.eta);
        medium_stack_cross(path.media, surface.material, surface.front_side);
    }
    if (roulette >= 0.0) {
        const float survival = min(max_component(path.throughput) * path.eta_scale, ROULETTE_MOST_SURVIVAL);
        if (!(roulette < survival)) return false;
        path.throughput /= survival;
    }
    path.light = NO_SAMPLED_LIGHT;
    ++path.scatterings;
    ++path.vertex;
    const vec3 wi = to_world(surface.shading, next.wi);
    path.ray = Ray(ray_origin(surface, wi), wi, INFINITY);
    return true;
}

/// What leaves the ray's end towards its beginning. False: the path ends. True: it goes on; `parted`: as well by the rough
/// part, as `apart`.
bool shade_end(inout GatherPath path, uint key, uint ray_index, inout Gathered gathered, out bool parted,
               out GatherPath apart) {
    parted = false;
    apart = path;
    Hit hit;
    ShadingPoint surface;
    if (!meet_end(path, hit, surface, gathered)) return false;
    const Bsdf bsdf = make_bsdf(surface, medium_stack_outside_ior(path.media, surface.material, !surface.front_side));
    const Bsdf rough = bsdf_is_lambert(bsdf) ? bsdf : bsdf_rough_part(bsdf, mapping.glossy_threshold);
    const vec3 wo = to_local(surface.shading, -path.ray.direction);
    const SplitSamplers samplers = gather_samplers();
    const vec2 direction = split_sample_2d(samplers, ray_index, key, sample_set(path.vertex, SET_DIRECTION));

    if (bsdf_scatters(rough)) {
        const vec2 choice =
            split_sample_2d(samplers, ray_index, key, sample_set(path.vertex, SET_LIGHT_CHOICE_AND_ROULETTE));
        const vec2 on_light = split_sample_2d(samplers, ray_index, key, sample_set(path.vertex, SET_LIGHT_POINT));
        const vec3 lit_normal = bsdf_has_non_delta_transmission(rough) ? vec3(0.0) : surface.shading.normal;
        // One ray by f_d beside one light sample.
        const bool looks_for_lights = mapping.lights_can_be_met != 0 && !bsdf_is_diffuse(rough);
        LightSample light_sample;
        if (sample_light(surface.position, lit_normal, choice.x, on_light, light_sample)) {
            const BsdfValue f = bsdf_evaluate(rough, wo, to_local(surface.shading, light_sample.wi));
            const float weight =
                looks_for_lights && !light_sample.delta ? power_heuristic(light_sample.pdf_sa, f.pdf_sa) : 1.0;
            const vec3 radiance = weight * path.throughput * f.f_cos * light_sample.radiance_over_pdf;
            if (!is_black(radiance)) {
                ++gathered.shadow_rays;
                if (!occluded(shadow_ray(light_sample, ray_origin(surface, light_sample.wi))))
                    gathered.indirect += radiance;
            }
        }
        const uint most = photon_scatterings_left(path.scatterings + 1);
        // A ray shorter than the radius of the lookup at its end begins where the disc is: in a corner, where density is
        // smeared and lost at the edge, and where all short rays see the same error. It goes on for one bounce.
        DiscQuery query = disc_query(disc_turn(direction), DISC_COARSE_BATCH);
        if (path.vertex == 1) query.most_radius_m = hit.t;
        MapEstimates maps = estimate_maps_at_end(surface, rough, wo, most, query);
        const bool goes_on = maps.global.radius_m > query.most_radius_m;
        if (goes_on) maps.global = no_radiance();
        gathered.indirect += path.throughput * (maps.caustic.radiance + maps.global.radiance);
        gathered.photons += maps.caustic.photons + maps.global.photons;
        if (goes_on || looks_for_lights) {
            const BsdfSample next = bsdf_sample(rough, wo, choice.y, direction);
            apart = path;
            if (follow_gathered(apart, surface, next, -1.0)) {
                apart.light = SampledLight(surface.position, lit_normal, looks_for_lights ? next.pdf_sa : 0.0);
                if (goes_on) {
                    parted = true;
                } else {
                    Hit unused_hit;
                    ShadingPoint unused_surface;
                    meet_end(apart, unused_hit, unused_surface, gathered);
                }
            }
        }
    }
    if (bsdf_is_lambert(bsdf)) return false;
    const Bsdf specular = bsdf_specular_part(bsdf, mapping.glossy_threshold);
    if (!bsdf_scatters(specular)) return false;
    // Many rays are averaged: roulette may end each from the start.
    const vec2 lobe = split_sample_2d(samplers, ray_index, key, sample_set(path.vertex, SET_LOBE));
    return follow_gathered(path, surface, bsdf_sample(specular, wo, lobe.x, direction), lobe.y);
}

/// A point that gathers: VisiblePoint, as far as it is needed here.
struct GatherPoint {
    ShadingPoint surface;
    Bsdf rough;  // f_d
    vec3 wo;     // local
    vec3 lit_normal;
    uint scatterings;
    MediumStack media;
    uint key;
    uint rays, light_samples;
};

/// Adds what one of the point's rays finds.
void gather_ray(GatherPoint point, uint ray_index, inout Gathered gathered) {
    const SplitSamplers samplers = gather_samplers();
    const vec2 u = split_sample_2d(samplers, ray_index, point.key, sample_set(0, SET_DIRECTION));
    const float u_lobe =
        ONLY_LAMBERT ? 0.0 : split_sample_2d(samplers, ray_index, point.key, sample_set(0, SET_LOBE)).x;
    const BsdfSample next = bsdf_sample(point.rough, point.wo, u_lobe, u);
    if (!bsdf_sample_valid(next) || is_black(next.weight)) return;
    GatherPath path = GatherPath(vec3(1.0), 1.0, point.scatterings, 0u, NO_SAMPLED_LIGHT, point.media,
                                 Ray(vec3(0.0), vec3(0.0), INFINITY));
    follow_gathered(path, point.surface, next, -1.0);
    path.light = SampledLight(point.surface.position, point.lit_normal,
                              next.pdf_sa * float(point.rays) / float(point.light_samples));
    GatherPath apart = path;
    bool waits = false;
    while (true) {
        bool parted;
        GatherPath rough;
        const bool on = shade_end(path, point.key, ray_index, gathered, parted, rough);
        if (parted) {
            apart = rough;
            waits = true;
        }
        if (on) continue;
        if (!waits) return;
        path = apart;
        waits = false;
    }
}

#endif
