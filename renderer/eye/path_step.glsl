// One step of a path from the eye: what it finds where its ray ends, a light sample, and the next ray. CPU twin:
// PathWavefront::shade_vertex() of eye/path_wavefront_general.cpp, with the same numbers.
#ifndef PHOTOND_PATH_STEP_GLSL
#define PHOTOND_PATH_STEP_GLSL

#include "renderer/eye/eye_vertex.glsl"

/// Shades the hit. False: the path ends; `pending` may be wanted all the same.
bool shade_path(uint vertex, uint key, Hit hit, inout EyePath path, inout Ray ray, inout PathLight light,
                out PendingLight pending) {
    pending = no_pending_light();
    EyeVertex met;
    if (!arrive(path, hit, ray, light) || !meet_surface(path, vertex, hit, ray, light, met)) return false;
    const vec2 choice = sample_2d(key, sample_set(vertex, SET_LIGHT_CHOICE_AND_ROULETTE));
    if (bsdf_has_non_delta(met.bsdf)) {
        LightSample light_sample;
        const vec2 u = sample_2d(key, sample_set(vertex, SET_LIGHT_POINT));
        if (sample_light(path.position, path.lit_normal, choice.x, u, light_sample)) {
            const BsdfValue f = bsdf_evaluate(met.bsdf, met.wo, to_local(met.surface.shading, light_sample.wi),
                                              TRANSPORT_RADIANCE);
            if (!is_black(f.f_cos)) {
                const float weight = light_sample.delta ? 1.0 : power_heuristic(light_sample.pdf_sa, f.pdf_sa);
                pending.ray = shadow_ray(light_sample, ray_origin(met.surface, light_sample.wi));
                pending.radiance = weight * path.throughput * f.f_cos * light_sample.radiance_over_pdf;
                pending.indirect = path.scatterings > 0;
                pending.wanted = true;
            }
        }
    }
    const float u_lobe = ONLY_LAMBERT ? 0.0 : sample_2d(key, sample_set(vertex, SET_LOBE)).x;
    const vec2 u_direction = sample_2d(key, sample_set(vertex, SET_DIRECTION));
    return leave_surface(path, met.surface, bsdf_sample(met.bsdf, met.wo, u_lobe, u_direction),
                         vertex + 1 >= eye.roulette_start, choice.y, light, ray);
}

/// Follows a path to its end; vertices are counted on from `vertex`, shadow rays added up.
void follow_path(uint key, inout uint vertex, EyePath path, Ray ray, inout PathLight light, inout uint shadow_rays) {
    bool goes_on = true;
    while (goes_on) {
        PendingLight pending;
        goes_on = shade_path(vertex, key, closest_hit(ray), path, ray, light, pending);
        if (pending.wanted) {
            ++shadow_rays;
            if (!occluded(pending.ray)) {
                if (pending.indirect) light.indirect += pending.radiance; else light.direct += pending.radiance;
            }
        }
        ++vertex;
    }
}

#endif
