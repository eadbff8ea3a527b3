// GLSL twin of many_lights/clamp_repayment.h: what connections leave out at a point, found by one ray, its path to the
// end. Define IMAGE_BINDING, COUNTERS_BINDING, EYE_BINDING and SAMPLER_BINDING (numbers of
// RandomDomain::Splats) before; and CAUSTIC_ESTIMATE_BINDING with the others of caustic_lookup.glsl where caustics may be
// photons. The point's own are looked up here too.
#ifndef PHOTOND_CLAMP_REPAYMENT_GLSL
#define PHOTOND_CLAMP_REPAYMENT_GLSL

#include "renderer/eye/eye_contributions.glsl"
#include "renderer/gbuffer/receiver.glsl"
#include "renderer/transport/roulette_shared.h"

#ifdef CAUSTIC_ESTIMATE_BINDING
#include "renderer/photons/caustic_lookup.glsl"
layout(constant_id = CAUSTICS_ARE_PHOTONS_ID) const bool CAUSTICS_ARE_PHOTONS = false;
#else
const bool CAUSTICS_ARE_PHOTONS = false;
vec3 caustic_radiance(ShadingPoint point, Bsdf rough, vec3 wo, uint most_scatterings) { return vec3(0.0); }
vec3 caustic_irradiance(vec3 position, vec3 geometric_normal, vec3 normal, uint most_scatterings) { return vec3(0.0); }
#endif

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

/// What is asked for, and the lobes that connect and are followed.
struct RepaymentSettings {
    bool clamped;
    bool narrow;
    float glossy_threshold;   // of eye paths
    float connect_threshold;  // of the rough part that connects: GGX alpha above it
};

/// What connections leave out: irradiance of Lambert points, radiance before the throughput of others.
struct LeftOut {
    vec3 clamped;
    vec3 narrow;
};


uint repayment_bounce_rays = 0, repayment_shadow_rays = 0;

/// ClampRepayment::Path: the throughput makes irradiance of radiance at Lambert points, radiance at others.
struct RepaymentPath {
    vec3 throughput;
    uint key;
    vec3 position;
    float pdf_sa;  // of the direction, against light samples
    vec3 lit_normal;
    bool delta;
    bool narrow;  // for LeftOut::narrow
    bool blind;   // came by lobes behind which lights do not count
    uint left;    // scatterings that lights may have had, the one at the next vertex included
    MediumStack media;
};

/// The part of a BSDF that connects: rough, and reflecting alone.
Bsdf connecting_part(Bsdf bsdf, float connect_threshold) {
    const Bsdf rough = bsdf_rough_part(bsdf, connect_threshold);
    if (bsdf_has_non_delta_transmission(rough)) return bsdf_nothing();
    return rough;
}

/// The normal that light samples go by; 0 where light comes from both sides.
vec3 repayment_lit_normal(Bsdf bsdf, ShadingPoint at) {
    return bsdf_has_non_delta_transmission(bsdf) ? vec3(0.0) : at.shading.normal;
}

/// One ray of the point. False: it brings nothing.
bool start_repayment(ClampedPoint point, GBufferGeneral of_general, RepaymentSettings settings, out RepaymentPath path,
                     out Ray ray) {
    path = RepaymentPath(vec3(PI), hash32(pixel_key(point.pixel) + point.most_scatterings), point.position, 0.0,
                         vec3(0.0), false, false, false, point.most_scatterings, make_medium_stack());
    ray = Ray(vec3(0.0), vec3(0.0), 0.0);
    if (point.most_scatterings == 0u) return false;
    vec2 u = sample_2d(path.key, sample_set(0, SET_DIRECTION));
    const bool general = !ONLY_LAMBERT && point.general;
    Receiver receiver;
    if (general) receiver = make_receiver(of_general, settings.glossy_threshold);
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
              settings.narrow ? INFINITY : sqrt(point.clamp_sq_m2));
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
            light_pdf =
                light_pdf_triangle(path.position, path.lit_normal, hit.instance, hit.triangle, direction, hit.t);
    }
    return path.throughput * radiance * (path.delta ? 1.0 : power_heuristic(path.pdf_sa, light_pdf));
}

/// `goes_on`: chance for the path on to be drawn by that BSDF, which may meet the same light.
vec3 repayment_light_sampled(uint vertex, RepaymentPath path, ShadingPoint at, Bsdf bsdf, vec3 wo, float goes_on) {
    LightSample light;
    const float choice = sample_2d(path.key, sample_set(vertex, SET_LIGHT_CHOICE_AND_ROULETTE)).x;
    const vec2 u = sample_2d(path.key, sample_set(vertex, SET_LIGHT_POINT));
    if (!sample_light(path.position, path.lit_normal, choice, u, light)) return vec3(0.0);
    const BsdfValue f = bsdf_evaluate(bsdf, wo, to_local(at.shading, light.wi));
    if (is_black(f.f_cos)) return vec3(0.0);
    const float weight = light.delta || !(goes_on > 0.0) ? 1.0 : power_heuristic(light.pdf_sa, goes_on * f.pdf_sa);
    ++repayment_shadow_rays;
    if (occluded(shadow_ray(light, ray_origin(at, light.wi)))) return vec3(0.0);
    return path.throughput * f.f_cos * light.radiance_over_pdf * weight;
}

/// ClampRepayment::Part: what the path may do at a vertex.
struct RepaymentPart {
    Bsdf bsdf;
    float share;  // of what it scatters
    bool narrow;
    bool blind;    // lights are neither sampled for it nor met by it
    float weight;  // of the choice to go on by it; 0: not by it
};

/// `may_meet_lights`: it goes on also where only a light is still to be met.
RepaymentPart repayment_part(RepaymentPath path, Bsdf bsdf, bool narrow, bool blind, float share, bool may_meet_lights) {
    const float scattered = bsdf_scatters(bsdf) ? share * max_component(bsdf_albedo(bsdf)) : 0.0;
    const bool goes_on = path.left > 0u || (may_meet_lights && !blind);
    if (!(scattered > 0.0)) return RepaymentPart(bsdf_nothing(), 0.0, narrow, blind, 0.0);
    return RepaymentPart(bsdf, share, narrow, blind, goes_on ? scattered : 0.0);
}
RepaymentPart no_repayment_part() { return RepaymentPart(bsdf_nothing(), 0.0, false, true, 0.0); }

RepaymentPath repayment_by_part(RepaymentPath path, RepaymentPart part, ShadingPoint at) {
    path.throughput *= part.share;
    path.narrow = part.narrow;
    path.blind = part.blind;
    path.lit_normal = repayment_lit_normal(part.bsdf, at);
    return path;
}

/// Light that comes to that part straight. `chance`: for the path to go on by it.
void add_repayment_light(uint vertex, RepaymentPath path, ShadingPoint at, RepaymentPart part, vec3 wo, float chance,
                         inout LeftOut sum) {
    if (part.blind || !bsdf_has_non_delta(part.bsdf)) return;
    const RepaymentPath by_part = repayment_by_part(path, part, at);
    vec3 light = repayment_light_sampled(vertex, by_part, at, part.bsdf, wo, chance);
    if (CAUSTICS_ARE_PHOTONS) light += by_part.throughput * caustic_radiance(at, part.bsdf, wo, path.left);
    if (part.narrow) sum.narrow += light; else sum.clamped += light;
}

/// Draws the path's next ray by that part; `chance`: for it to have come to that. `choice`: of a lobe, and of roulette.
/// False: the path ends.
bool leave_repayment(uint vertex, ShadingPoint at, RepaymentPart part, vec3 wo, float chance, vec2 choice,
                     inout RepaymentPath path, inout Ray ray) {
    const BsdfSample next =
        bsdf_sample(part.bsdf, wo, choice.x, sample_2d(path.key, sample_set(vertex + 1, SET_DIRECTION)));
    if (!bsdf_sample_valid(next)) return false;
    path = repayment_by_part(path, part, at);
    path.throughput *= next.weight / chance;
    path.pdf_sa = next.pdf_sa * chance;
    path.delta = next.delta;
    if (next.refraction) medium_stack_cross(path.media, at.material, at.front_side);
    if (vertex >= ROULETTE_START) {
        const float survival = min(max_component(path.throughput) * INV_PI, ROULETTE_MOST_SURVIVAL);
        if (!(choice.y < survival)) return false;
        path.throughput /= survival;
    }
    const vec3 w = to_world(at.shading, next.wi);
    ray = Ray(ray_origin(at, w), w, INFINITY);
    return true;
}

/// Adds the light that comes to the parts, and sends the path on by one of them at the most. False: it ends.
bool scatter_repayment_parts(uint vertex, ShadingPoint at, vec3 wo, RepaymentPart one, RepaymentPart two,
                             RepaymentPart three, inout RepaymentPath path, inout Ray ray, inout LeftOut sum) {
    const float total = one.weight + two.weight + three.weight;
    const vec3 chances =
        total > 0.0 ? vec3(one.weight, two.weight, three.weight) / total : vec3(0.0);
    add_repayment_light(vertex, path, at, one, wo, chances.x, sum);
    add_repayment_light(vertex, path, at, two, wo, chances.y, sum);
    add_repayment_light(vertex, path, at, three, wo, chances.z, sum);
    if (!(total > 0.0)) return false;
    const vec2 choice = sample_2d(path.key, sample_set(vertex + 1, SET_LOBE));
    RepaymentPart part = one;
    float below = 0.0, chance = chances.x;
    if (choice.y >= chances.x) {
        part = two;
        below = chances.x, chance = chances.y;
        if (choice.y >= below + chance) {
            part = three;
            below += chance, chance = chances.z;
        }
    }
    return chance > 0.0 &&
           leave_repayment(vertex, at, part, wo, chance, vec2(choice.x, (choice.y - below) / chance), path, ray);
}

/// The first vertex: of the part that connects what the clamp took, of the other all.
bool scatter_first_repayment(ClampedPoint point, RepaymentSettings settings, ShadingPoint at, Bsdf whole, vec3 wo,
                             float distance_m, inout RepaymentPath path, inout Ray ray, inout LeftOut sum) {
    const Bsdf connecting = connecting_part(whole, settings.connect_threshold);
    const float share = settings.clamped ? 1.0 - min(sqr(distance_m) / point.clamp_sq_m2, 1.0) : 0.0;
    RepaymentPart clamped = no_repayment_part(), rough = clamped, specular = clamped;
    if (share > 0.0) clamped = repayment_part(path, connecting, false, false, share, false);
    if (settings.narrow) {
        Bsdf narrow = whole;
        if (bsdf_scatters(connecting)) narrow = bsdf_specular_part(whole, settings.connect_threshold);
        if (CAUSTICS_ARE_PHOTONS) {
            const float threshold = min(settings.glossy_threshold, settings.connect_threshold);
            rough = repayment_part(path, bsdf_rough_part(narrow, threshold), true, false, 1.0, true);
            specular = repayment_part(path, bsdf_specular_part(narrow, threshold), true, true, 1.0, true);
        } else {
            rough = repayment_part(path, narrow, true, false, 1.0, true);
        }
    }
    return scatter_repayment_parts(0, at, wo, clamped, rough, specular, path, ray, sum);
}

/// A later one: everything.
bool scatter_later_repayment(uint vertex, RepaymentSettings settings, ShadingPoint at, Bsdf whole, vec3 wo,
                             inout RepaymentPath path, inout Ray ray, inout LeftOut sum) {
    RepaymentPart rough, specular = no_repayment_part();
    if (!CAUSTICS_ARE_PHOTONS || bsdf_is_lambert(whole)) {
        // Light that the path on from here may meet is found in two ways; a last vertex has light samples alone.
        const bool goes_on = path.left > 0u || (bsdf_has_delta(whole) && !CAUSTICS_ARE_PHOTONS);
        if (!bsdf_scatters(whole)) return false;
        rough = RepaymentPart(whole, 1.0, path.narrow, false, goes_on ? 1.0 : 0.0);
    } else {
        const float threshold = min(settings.glossy_threshold, settings.connect_threshold);
        rough = repayment_part(path, bsdf_rough_part(whole, threshold), path.narrow, false, 1.0, false);
        specular = repayment_part(path, bsdf_specular_part(whole, threshold), path.narrow, true, 1.0, false);
    }
    return scatter_repayment_parts(vertex, at, wo, rough, specular, no_repayment_part(), path, ray, sum);
}

/// Adds the light at the ray's end and sends the path on. False: it ends.
bool scatter_repayment(uint vertex, ClampedPoint point, RepaymentSettings settings, inout RepaymentPath path,
                       inout Ray ray, inout LeftOut sum) {
    ++repayment_bounce_rays;
    const Hit hit = closest_hit(ray);
    if (hit_valid(hit)) path.throughput *= transmittance(path.media, hit.t);
    if (vertex > 0 && !path.blind) {
        const vec3 met = repayment_light_met(path, hit, ray.direction);
        if (path.narrow) sum.narrow += met; else sum.clamped += met;
    }
    if (!hit_valid(hit) || path.left == 0u) return false;
    --path.left;

    const ShadingPoint at = make_shading_point(hit, ray.direction);
    if (NEEDS_UNLIT && has_flag(scene_materials[at.material].flags, MATERIAL_UNLIT)) return false;
    const Bsdf whole = make_bsdf(at, medium_stack_outside_ior(path.media, at.material, !at.front_side));
    const vec3 wo = to_local(at.shading, -ray.direction);
    path.position = at.position;
    if (vertex == 0) return scatter_first_repayment(point, settings, at, whole, wo, hit.t, path, ray, sum);
    return scatter_later_repayment(vertex, settings, at, whole, wo, path, ray, sum);
}

/// Caustics at the point itself.
vec3 repayment_caustics(ClampedPoint point, GBufferGeneral of_general, RepaymentSettings settings) {
    if (!ONLY_LAMBERT && point.general) {
        const Receiver receiver = make_receiver(of_general, settings.glossy_threshold);
        return caustic_radiance(receiver.surface, receiver.rough, receiver.wo, point.most_scatterings);
    }
    return caustic_irradiance(point.position, point.geometric_normal, point.normal, point.most_scatterings);
}

/// `of_general` is read of points that are not Lambert alone.
LeftOut clamp_repayment(ClampedPoint point, GBufferGeneral of_general, RepaymentSettings settings) {
    RepaymentPath path;
    Ray ray;
    LeftOut sum = LeftOut(vec3(0.0), vec3(0.0));
    if (CAUSTICS_ARE_PHOTONS) sum.narrow += repayment_caustics(point, of_general, settings);
    if (!start_repayment(point, of_general, settings, path, ray)) return sum;
    for (uint vertex = 0; scatter_repayment(vertex, point, settings, path, ray, sum);) ++vertex;
    return sum;
}

#endif
