// A path from the eye at a surface, where it is to be joined with light paths. CPU twin: eye_paths.cpp, with the same
// numbers. Define IMAGE_BINDING, EYE_BINDING, SAMPLER_BINDING and what bidirectional.glsl wants (of set 0) before.
#ifndef PHOTOND_JOINED_EYE_PATH_GLSL
#define PHOTOND_JOINED_EYE_PATH_GLSL

#include "renderer/bidirectional/join_vertex.glsl"
#include "renderer/eye/camera_connection.glsl"
#include "renderer/eye/eye_vertex.glsl"

SubpathWeights start_weights(Ray ray) { return mis_start_eye(camera_pdf(eye.camera, ray.direction)); }

void meet_environment(uint vertex, EyePath path, SubpathWeights weights, vec3 towards, inout PathLight light) {
    if (!NEEDS_ENVIRONMENT) return;
    const vec3 radiance = path.throughput * environment_radiance(towards);
    if (is_black(radiance)) return;
    float weight = 1.0;
    if (vertex > 0)
        weight = mis_light_met(weights, light_end_of_environment(path.position, path.lit_normal, towards),
                               techniques.numbers);
    add_radiance(light, path, weight * radiance);
}

void meet_light(uint vertex, EyePath path, SubpathWeights weights, Hit hit, bool front, vec3 towards,
                inout PathLight light) {
    const vec3 emitted = emitted_radiance(hit.instance, hit.triangle, hit.u, hit.v, front);
    if (is_black(emitted)) return;
    float weight = 1.0;
    if (vertex > 0)
        weight = mis_light_met(weights,
                               light_end_on_triangle(path.position, path.lit_normal, hit.instance, hit.triangle,
                                                     towards, hit.t),
                               techniques.numbers);
    add_radiance(light, path, weight * path.throughput * emitted);
}

PendingLight sample_light_of(uint vertex, uint key, JoinVertex at, float u_choice) {
    PendingLight pending = no_pending_light();
    LightSample light_sample;
    const vec2 u = sample_2d(key, sample_set(vertex, SET_LIGHT_POINT));
    if (!sample_light(at.path.position, at.path.lit_normal, u_choice, u, light_sample)) return pending;
    const EyeScattering scattering = scatter_to_light(at.surface, light_sample.wi);
    if (is_black(scattering.f_cos)) return pending;
    float pdf_direct_sa;
    const LightEnd end = light_end_of_sample(light_sample, pdf_direct_sa);
    const float cosine = abs(dot(at.surface.point.geometric_normal, light_sample.wi));
    const VertexSide side = VertexSide(vertex == 0, scattering.light_pdf, at.acceptance);
    const float weight = mis_next_event(at.weights, side, scattering.eye_pdf, pdf_direct_sa, cosine, end,
                                        techniques.numbers);
    pending.ray = shadow_ray(light_sample, ray_origin(at.surface.point, light_sample.wi));
    pending.radiance = weight * at.path.throughput * scattering.f_cos * light_sample.radiance_over_pdf;
    pending.indirect = at.path.scatterings > 0;
    pending.wanted = !is_black(pending.radiance);
    return pending;
}

/// All that a path does by itself at the end of its ray. `joins`: `at` is to be joined with light paths. False: the path
/// ends; both others may be wanted all the same.
bool shade_joined(uint vertex, uint key, Hit hit, inout EyePath path, inout SubpathWeights weights, inout Ray ray,
                  inout PathLight light, out PendingLight pending, out JoinVertex at, out bool joins) {
    pending = no_pending_light();
    joins = false;
    path.throughput *= transmittance(path.media, hit.t);
    if (!hit_valid(hit)) {
        meet_environment(vertex, path, weights, ray.direction, light);
        return false;
    }
    EyeVertex met;
    if (!see_surface(path, vertex, hit, ray, light, met.surface)) return false;
    const bool across = vertex == 0 && eye.camera.orthographic != 0;
    mis_arrive(weights, across ? 1.0 : sqr(hit.t), max(abs(dot(met.surface.geometric_normal, ray.direction)), 1e-12));
    if (is_emissive(met.surface.material))
        meet_light(vertex, path, weights, hit, met.surface.front_side, ray.direction, light);
    at.outside_ior = medium_stack_outside_ior(path.media, met.surface.material, !met.surface.front_side);
    if (!open_surface(path, ray, light, met)) return false;
    at.surface = SurfaceVertex(met.surface, met.bsdf, -ray.direction);
    path.lit_normal = lit_normal_of(at.surface);
    at.path = path;
    at.weights = weights;
    at.acceptance = 0.0;
    const vec2 choice = sample_2d(key, sample_set(vertex, SET_LIGHT_CHOICE_AND_ROULETTE));
    if (bsdf_has_non_delta(met.bsdf)) {
        joins = true;
        at.acceptance = merge_acceptance(met.surface.position, false);
        pending = sample_light_of(vertex, key, at, choice.x);
    }
    const float u_lobe = ONLY_LAMBERT ? 0.0 : sample_2d(key, sample_set(vertex, SET_LOBE)).x;
    const vec2 u_direction = sample_2d(key, sample_set(vertex, SET_DIRECTION));
    const BsdfSample next = bsdf_sample(met.bsdf, met.wo, u_lobe, u_direction);
    if (!leave_surface(path, met.surface, next, vertex + 1 >= eye.roulette_start, choice.y, light, ray)) return false;
    const float cos_out = abs(dot(met.surface.geometric_normal, ray.direction));
    if (next.delta)
        mis_scatter_delta(weights, cos_out);
    else
        mis_scatter(weights, VertexSide(vertex == 0, light_pdf_back(at.surface, ray.direction), at.acceptance),
                    next.pdf_sa, cos_out);
    return true;
}

#endif
