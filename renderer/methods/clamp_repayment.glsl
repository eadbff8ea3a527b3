// GLSL twin of methods/clamp_repayment.h: what the clamp of connections takes from a point, found by one short ray, its path
// to the end. Define IMAGE_BINDING, COUNTERS_BINDING, EYE_BINDING and SAMPLER_BINDING (numbers of RandomDomain::Splats)
// before.
#ifndef PHOTOND_CLAMP_REPAYMENT_GLSL
#define PHOTOND_CLAMP_REPAYMENT_GLSL

#include "renderer/methods/eye_contributions.glsl"
#include "renderer/methods/receiver.glsl"

/// ClampedPoint of clamp_repayment.h.
struct ClampedPoint {
    vec3 position;  // world [m]
    uint pixel;
    vec3 normal;            // that shades
    uint most_scatterings;  // of the light that connects
    vec3 geometric_normal;  // unit, on the eye's side
    bool general;           // not Lambert
    float clamp_sq_m2;      // B
};

const uint REPAYMENT_ROULETTE_START = 4;  // kRouletteStart

uint repayment_bounce_rays = 0, repayment_shadow_rays = 0;

/// ClampRepayment::Path: the throughput makes irradiance of radiance at Lambert points, radiance at others.
struct RepaymentPath {
    vec3 throughput;
    uint key;
    vec3 position;
    float pdf_sa;  // of the direction, against light samples
    vec3 lit_normal;
    bool delta;
    MediumStack media;
};

/// The part of a BSDF that connects: rough, and reflecting alone.
Bsdf connecting_part(Bsdf bsdf, float connect_threshold) {
    const Bsdf rough = bsdf_rough_part(bsdf, connect_threshold);
    if (bsdf_has_non_delta_transmission(rough)) return bsdf_nothing();
    return rough;
}

/// One short ray of the point. False: it brings nothing.
bool start_repayment(ClampedPoint point, GBufferGeneral of_general, float glossy_threshold, out RepaymentPath path,
                     out Ray ray) {
    path = RepaymentPath(vec3(PI), hash32(pixel_key(point.pixel) + point.most_scatterings), point.position, 0.0,
                         vec3(0.0), false, make_medium_stack());
    ray = Ray(vec3(0.0), vec3(0.0), 0.0);
    if (point.most_scatterings == 0u) return false;
    vec2 u = sample_2d(path.key, sample_set(0, SET_DIRECTION));
    const bool general = !ONLY_LAMBERT && point.general;
    Receiver receiver;
    if (general) receiver = make_receiver(of_general, glossy_threshold);
    const bool both_sides = general && bsdf_has_non_delta_transmission(receiver.rough);
    bool below = false;
    if (both_sides) {
        below = u.x >= 0.5;
        u.x = 2.0 * u.x - (below ? 1.0 : 0.0);
    }
    vec3 local = sample_cosine_hemisphere(u);
    if (below) local.z = -local.z;
    const vec3 w = to_world(make_frame(general ? receiver.surface.shading.normal : point.normal), local);
    const bool front = dot(point.geometric_normal, w) > 0.0;
    if (!both_sides && !front) return false;
    if (general) {
        const float pdf = abs(local.z) * INV_PI * (both_sides ? 0.5 : 1.0);
        path.throughput = bsdf_f_cos(receiver.rough, receiver.wo, to_local(receiver.surface.shading, w)) / pdf;
        path.media = MediumStack(of_general.media);
        if (is_black(path.throughput)) return false;
    }
    ray = Ray(offset_ray_origin(point.position, front ? point.geometric_normal : -point.geometric_normal), w,
              sqrt(point.clamp_sq_m2));
    return true;
}

/// Light that a path on from y meets.
vec3 repayment_light_met(RepaymentPath path, Hit hit, vec3 direction) {
    vec3 radiance = vec3(0.0);
    float light_pdf = 0.0;
    if (!hit_valid(hit)) {
        if (!NEEDS_ENVIRONMENT) return radiance;
        radiance = environment_radiance(direction);
        if (!path.delta) light_pdf = light_pdf_environment(path.position, path.lit_normal, direction);
    } else if (NEEDS_AREA_LIGHTS) {
        const ShadingPoint met = make_shading_point(hit, direction);
        radiance = emitted_radiance(hit.instance, hit.triangle, hit.u, hit.v, met.front_side);
        if (!path.delta && !is_black(radiance))
            light_pdf = light_pdf_triangle(path.position, path.lit_normal, hit.instance, hit.triangle, direction, hit.t);
    }
    return path.throughput * radiance * (path.delta ? 1.0 : power_heuristic(path.pdf_sa, light_pdf));
}

vec3 repayment_light_sampled(uint vertex, RepaymentPath path, ShadingPoint at, Bsdf bsdf, vec3 wo, bool competes) {
    LightSample light;
    const float choice = sample_2d(path.key, sample_set(vertex, SET_LIGHT_CHOICE_AND_ROULETTE)).x;
    const vec2 u = sample_2d(path.key, sample_set(vertex, SET_LIGHT_POINT));
    if (!sample_light(path.position, path.lit_normal, choice, u, light)) return vec3(0.0);
    const BsdfValue f = bsdf_evaluate(bsdf, wo, to_local(at.shading, light.wi));
    if (is_black(f.f_cos)) return vec3(0.0);
    const float weight = light.delta || !competes ? 1.0 : power_heuristic(light.pdf_sa, f.pdf_sa);
    ++repayment_shadow_rays;
    if (occluded(shadow_ray(light, ray_origin(at, light.wi)))) return vec3(0.0);
    return path.throughput * f.f_cos * light.radiance_over_pdf * weight;
}

/// Adds the light at the ray's end and sends the path on. `left`: scatterings that light may have had, the one at this
/// vertex included. False: the path ends.
bool scatter_repayment(uint vertex, uint left, ClampedPoint point, float connect_threshold, inout RepaymentPath path,
                       inout Ray ray, inout vec3 sum) {
    ++repayment_bounce_rays;
    const Hit hit = closest_hit(ray);
    if (hit_valid(hit)) path.throughput *= transmittance(path.media, hit.t);
    if (vertex > 0)
        sum += repayment_light_met(path, hit, ray.direction);
    else if (hit_valid(hit))
        path.throughput *= 1.0 - min(sqr(hit.t) / point.clamp_sq_m2, 1.0);
    if (!hit_valid(hit) || left == 0u) return false;

    const ShadingPoint at = make_shading_point(hit, ray.direction);
    if (NEEDS_UNLIT && has_flag(scene_materials[at.material].flags, MATERIAL_UNLIT)) return false;
    const Bsdf whole = make_bsdf(at, medium_stack_outside_ior(path.media, at.material, !at.front_side));
    Bsdf bsdf = whole;
    if (vertex == 0) bsdf = connecting_part(whole, connect_threshold);
    if (!bsdf_scatters(bsdf)) return false;
    const vec3 wo = to_local(at.shading, -ray.direction);
    path.position = at.position;
    path.lit_normal = bsdf_has_non_delta_transmission(bsdf) ? vec3(0.0) : at.shading.normal;
    // Light that the path on from here may meet is found in two ways; a last vertex has light samples alone.
    const bool goes_on = left > 1u || bsdf_has_delta(bsdf);
    if (bsdf_has_non_delta(bsdf)) sum += repayment_light_sampled(vertex, path, at, bsdf, wo, goes_on);
    if (!goes_on) return false;

    const vec2 choice = sample_2d(path.key, sample_set(vertex + 1, SET_LOBE));
    const BsdfSample next = bsdf_sample(bsdf, wo, choice.x, sample_2d(path.key, sample_set(vertex + 1, SET_DIRECTION)));
    if (!bsdf_sample_valid(next)) return false;
    path.throughput *= next.weight;
    path.pdf_sa = next.pdf_sa;
    path.delta = next.delta;
    if (next.refraction) medium_stack_cross(path.media, at.material, at.front_side);
    if (vertex >= REPAYMENT_ROULETTE_START) {
        const float survival = min(max_component(path.throughput) * INV_PI, kMaxSurvival);
        if (!(choice.y < survival)) return false;
        path.throughput /= survival;
    }
    const vec3 w = to_world(at.shading, next.wi);
    ray = Ray(ray_origin(at, w), w, INFINITY);
    return true;
}

/// Irradiance of Lambert points, of others radiance before the throughput: `of_general` is read of these alone.
vec3 clamp_repayment(ClampedPoint point, GBufferGeneral of_general, float glossy_threshold, float connect_threshold) {
    RepaymentPath path;
    Ray ray;
    vec3 sum = vec3(0.0);
    if (!start_repayment(point, of_general, glossy_threshold, path, ray)) return sum;
    uint left = point.most_scatterings;
    for (uint vertex = 0; scatter_repayment(vertex, left, point, connect_threshold, path, ray, sum); ++vertex)
        left -= min(left, 1u);
    return sum;
}

#endif
