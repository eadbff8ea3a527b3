#version 460
// What the clamp of connections takes, given back by one short ray a visible point: CPU twin Repayment, which says what is
// found. A thread a point, its path to the end.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define IMAGE_BINDING 0
#define COUNTERS_BINDING 1
#define EYE_BINDING 2
#define SAMPLER_BINDING 3
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/methods/eye_contributions.glsl"
#include "renderer/methods/photon_splatting/splat_gain.glsl"
#include "renderer/methods/photon_splatting/visible_points.glsl"

layout(local_size_x = SPLAT_GROUP) in;
layout(push_constant, scalar) uniform Push { SplatPointPush push; };
layout(set = 0, binding = 4, scalar) readonly buffer Constants { SplatConstants constants; };
layout(set = 0, binding = 5, scalar) readonly buffer Points { SplatPoint points[]; };
layout(set = 0, binding = 6, scalar) readonly buffer GeneralPoints { SplatGeneralPoint general_points[]; };
layout(set = 0, binding = 7, scalar) buffer Sums { SplatSum sums[]; };

const uint ROULETTE_START = 4;  // kRouletteStart

uint bounce_rays = 0, shadow_rays = 0;

/// Repayment::Path: the throughput makes irradiance of radiance at Lambert points, radiance at others.
struct RepaymentPath {
    vec3 throughput;
    uint key;
    vec3 position;
    float pdf_sa;  // of the direction, against light samples
    vec3 lit_normal;
    bool delta;
    MediumStack media;
};

/// The part of a BSDF whose photons connect: rough, and reflecting alone.
Bsdf connecting_part(Bsdf bsdf) {
    const Bsdf rough = bsdf_rough_part(bsdf, constants.photon_threshold);
    if (bsdf_has_non_delta_transmission(rough)) return bsdf_nothing();
    return rough;
}

/// One short ray of the point. False: it brings nothing.
bool start_repayment(uint index, SplatPoint point, out RepaymentPath path, out Ray ray) {
    const uint most_scatterings = point.kind & ~POINT_GENERAL;
    path = RepaymentPath(vec3(PI), hash32(pixel_key(point.pixel) + most_scatterings), point.position, 0.0, vec3(0.0),
                         false, make_medium_stack());
    ray = Ray(vec3(0.0), vec3(0.0), 0.0);
    if (most_scatterings == 0) return false;
    vec2 u = sample_2d(path.key, sample_set(0, SET_DIRECTION));
    const bool general = is_general(point);
    Receiver receiver;
    if (general) receiver = make_receiver(general_points[index], constants.glossy_threshold);
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
        path.media = MediumStack(general_points[index].media);
        if (is_black(path.throughput)) return false;
    }
    ray = Ray(offset_ray_origin(point.position, front ? point.geometric_normal : -point.geometric_normal), w,
              sqrt(clamp_sq_m2(point.splat_radius_m)));
    return true;
}

/// Light that a path on from y meets.
vec3 light_met(RepaymentPath path, Hit hit, vec3 direction) {
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

vec3 light_sampled(uint vertex, RepaymentPath path, ShadingPoint at, Bsdf bsdf, vec3 wo, bool competes) {
    LightSample light;
    const float choice = sample_2d(path.key, sample_set(vertex, SET_LIGHT_CHOICE_AND_ROULETTE)).x;
    const vec2 u = sample_2d(path.key, sample_set(vertex, SET_LIGHT_POINT));
    if (!sample_light(path.position, path.lit_normal, choice, u, light)) return vec3(0.0);
    const BsdfValue f = bsdf_evaluate(bsdf, wo, to_local(at.shading, light.wi));
    if (is_black(f.f_cos)) return vec3(0.0);
    const float weight = light.delta || !competes ? 1.0 : power_heuristic(light.pdf_sa, f.pdf_sa);
    ++shadow_rays;
    if (occluded(shadow_ray(light, ray_origin(at, light.wi)))) return vec3(0.0);
    return path.throughput * f.f_cos * light.radiance_over_pdf * weight;
}

/// Adds the light at the ray's end and sends the path on. `left`: scatterings that photons may have had before the one at
/// this vertex; below 0 when only a light was still to be met. False: the path ends.
bool scatter(uint vertex, int left, SplatPoint point, inout RepaymentPath path, inout Ray ray, inout vec3 sum) {
    ++bounce_rays;
    const Hit hit = closest_hit(ray);
    if (hit_valid(hit)) path.throughput *= transmittance(path.media, hit.t);
    if (vertex > 0)
        sum += light_met(path, hit, ray.direction);
    else if (hit_valid(hit))
        path.throughput *= 1.0 - min(sqr(hit.t) / clamp_sq_m2(point.splat_radius_m), 1.0);
    if (!hit_valid(hit) || left < 0) return false;

    const ShadingPoint at = make_shading_point(hit, ray.direction);
    if (NEEDS_UNLIT && has_flag(scene_materials[at.material].flags, MATERIAL_UNLIT)) return false;
    const Bsdf whole = make_bsdf(at, medium_stack_outside_ior(path.media, at.material, !at.front_side));
    Bsdf bsdf = whole;
    if (vertex == 0) bsdf = connecting_part(whole);
    if (!bsdf_scatters(bsdf)) return false;
    const vec3 wo = to_local(at.shading, -ray.direction);
    path.position = at.position;
    path.lit_normal = bsdf_has_non_delta_transmission(bsdf) ? vec3(0.0) : at.shading.normal;
    // Light that the path on from here may meet is found in two ways; a last vertex has light samples alone.
    const bool goes_on = left > 0 || bsdf_has_delta(bsdf);
    if (bsdf_has_non_delta(bsdf)) sum += light_sampled(vertex, path, at, bsdf, wo, goes_on);
    if (!goes_on) return false;

    const vec2 choice = sample_2d(path.key, sample_set(vertex + 1, SET_LOBE));
    const BsdfSample next = bsdf_sample(bsdf, wo, choice.x, sample_2d(path.key, sample_set(vertex + 1, SET_DIRECTION)));
    if (!bsdf_sample_valid(next)) return false;
    path.throughput *= next.weight;
    path.pdf_sa = next.pdf_sa;
    path.delta = next.delta;
    if (next.refraction) medium_stack_cross(path.media, at.material, at.front_side);
    if (vertex >= ROULETTE_START) {
        const float survival = min(max_component(path.throughput) * INV_PI, kMaxSurvival);
        if (!(choice.y < survival)) return false;
        path.throughput /= survival;
    }
    const vec3 w = to_world(at.shading, next.wi);
    ray = Ray(ray_origin(at, w), w, INFINITY);
    return true;
}

void main() {
    const uint index = push.first_point + flat_index();
    if (index < push.end_point) {
        const SplatPoint point = points[index];
        RepaymentPath path;
        Ray ray;
        if (start_repayment(index, point, path, ray)) {
            int left = int(point.kind & ~POINT_GENERAL) - 1;
            vec3 sum = vec3(0.0);
            for (uint vertex = 0; scatter(vertex, left, point, path, ray, sum); ++vertex) --left;
            sums[index].sum += sum;
        }
        count(COUNTER_BOUNCE_RAYS, bounce_rays);
        count(COUNTER_SHADOW_RAYS, shadow_rays);
    }
}
