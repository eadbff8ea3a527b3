#include "renderer/many_lights/clamp_repayment.h"

#include "renderer/transport/emission.h"
#include "renderer/transport/mis.h"
#include "renderer/transport/roulette_shared.h"
#include "renderer/transport/sampling.h"

namespace photond {

namespace {

/// The part of a BSDF whose photons connect: rough, and reflecting alone (photon_tracer.h).
Bsdf connecting_part(const Bsdf& bsdf, float threshold) {
    const Bsdf rough = bsdf.rough_part(threshold);
    return rough.has_non_delta_transmission() ? Bsdf() : rough;
}

/// The normal that light samples go by; 0 where light comes from both sides.
vec3 lit_normal_of(const Bsdf& bsdf, const ShadingPoint& at) {
    return bsdf.has_non_delta_transmission() ? vec3(0) : at.shading.normal;
}

}  // namespace

void ClampRepayment::repay(const RepaymentScene& shared, const PassSampler& sampler,
                           std::span<const ClampedPoint> points, float clamp_sq_m2, const LeftOut& left_out,
                           Counts& counts) {
    clamp_sq_m2_ = clamp_sq_m2;
    left_out_ = left_out;
    start(sampler, points);
    for (uint32_t vertex = 0; batch_.count > 0; ++vertex) {
        batch_.find_hits(shared.eye.intersector, Coherence::Incoherent);
        counts.bounce_rays += batch_.count;
        for (size_t i = 0; i < batch_.count; ++i) scatter(shared, sampler, vertex, i);
        counts.shadow_rays += shadows_.trace(shared.eye.intersector, Coherence::Incoherent,
                                             [&](const Light& light) { add(light.point, light.narrow, light.light); });
        batch_.advance();
    }
}

/// One short ray a point. The throughput makes irradiance of radiance at Lambert points, radiance at others.
void ClampRepayment::start(const PassSampler& sampler, std::span<const ClampedPoint> points) {
    const float reach_m = left_out_.narrow.empty() ? std::sqrt(clamp_sq_m2_) : kInfinity;
    // Each path goes on as one at the most, and the first vertex draws light samples of two parts.
    batch_.make_room(points.size());
    shadows_.make_room(2 * points.size());
    batch_.count = 0;
    for (uint32_t i = 0; i < points.size(); ++i) {
        const ClampedPoint& point = points[i];
        if (point.most_scatterings == 0) continue;
        const vec3& position = point.position;
        const vec3& geometric = point.geometric_normal;
        const VisiblePoint* general = point.general;
        const uint32_t key = hash32(sampler.pixel_key(point.pixel) + point.most_scatterings);
        vec2 u = sampler.sample_2d(key, sample_set(0, VertexSet::Direction));
        const bool both_sides = general && general->rough.has_non_delta_transmission();
        bool below = false;
        if (both_sides) {
            below = u.x >= 0.5f;
            u.x = 2 * u.x - (below ? 1.0f : 0.0f);
        }
        const Frame frame(general ? general->surface.shading.normal : point.normal);
        vec3 local = sample_cosine_hemisphere(u);
        if (below) local.z = -local.z;
        const vec3 w = frame.to_world(local);
        const bool front = glm::dot(geometric, w) > 0;
        if (!both_sides && !front) continue;
        Path path{.throughput = Rgb(kPi), .point = i, .left = point.most_scatterings, .media = {}};
        if (general) {
            const vec3 wi = general->surface.shading.to_local(w);
            const float pdf = std::fabs(local.z) * kInvPi * (both_sides ? 0.5f : 1.0f);
            path.throughput = general->rough.f_cos(general->wo, wi) / pdf;
            path.media = general->media;
            if (is_black(path.throughput)) continue;
        }
        path.position = position;
        batch_.paths[batch_.count] = path;
        batch_.keys[batch_.count] = key;
        batch_.rays[batch_.count++] = {offset_ray_origin(position, front ? geometric : -geometric), w, reach_m};
    }
}

void ClampRepayment::add(uint32_t point, bool narrow, const Rgb& light) {
    (narrow ? left_out_.narrow : left_out_.clamped)[point] += light;
}

/// Lists a part of the first vertex or a later one. `may_meet_lights`: also where only a light is still to be met.
void ClampRepayment::add_part(const Path& path, const Bsdf& bsdf, bool narrow, bool blind, float share,
                              bool may_meet_lights) {
    const float scattered = bsdf.scatters() ? share * max_component(bsdf.albedo()) : 0.0f;
    if (!(scattered > 0)) return;
    const bool goes_on = path.left > 0 || (may_meet_lights && !blind);
    parts_.push_back({bsdf, share, narrow, blind, goes_on ? scattered : 0.0f});
}

/// What connections leave out: of the part that connects what the clamp took, of the other all.
void ClampRepayment::list_first_parts(const RepaymentScene& shared, const Path& path, const Bsdf& whole,
                                      float clamped_share) {
    const Bsdf connecting = connecting_part(whole, shared.connect_threshold);
    if (clamped_share > 0) add_part(path, connecting, false, false, clamped_share, false);
    if (left_out_.narrow.empty()) return;
    const Bsdf narrow = connecting.scatters() ? whole.specular_part(shared.connect_threshold) : whole;
    if (!shared.caustics) return add_part(path, narrow, true, false, 1, true);
    add_part(path, narrow.rough_part(shared.caustics->glossy_threshold), true, false, 1, true);
    add_part(path, narrow.specular_part(shared.caustics->glossy_threshold), true, true, 1, true);
}

/// The same where the path has been reflected before: everything.
void ClampRepayment::list_parts(const RepaymentScene& shared, const Path& path, const Bsdf& whole) {
    if (!shared.caustics || whole.is_lambert()) {
        // Light that the path on from here may meet is found in two ways; a last vertex has light samples alone.
        const bool goes_on = path.left > 0 || (whole.has_delta() && !shared.caustics);
        if (whole.scatters()) parts_.push_back({whole, 1, path.narrow, false, goes_on ? 1.0f : 0.0f});
        return;
    }
    add_part(path, whole.rough_part(shared.caustics->glossy_threshold), path.narrow, false, 1, false);
    add_part(path, whole.specular_part(shared.caustics->glossy_threshold), path.narrow, true, 1, false);
}

/// Adds the light at the end of ray i, and sends the path on.
void ClampRepayment::scatter(const RepaymentScene& shared, const PassSampler& sampler, uint32_t vertex, size_t i) {
    const Scene& scene = shared.eye.scene;
    Path path = batch_.paths[i];
    const uint32_t key = batch_.keys[i];
    const Hit& hit = batch_.hits[i];
    const vec3& direction = batch_.rays[i].direction;
    if (hit.valid()) path.throughput *= shared.eye.absorption.transmittance(path.media, hit.t);
    if (vertex > 0 && !path.blind) add_light_met(shared, path, hit, direction);
    if (!hit.valid() || path.left == 0) return;
    --path.left;

    const ShadingPoint at = make_shading_point(scene, hit, direction);
    if (scene.materials[at.material].unlit) return;
    const Bsdf whole = make_bsdf(scene, at, path.media.outside_ior(scene, at.material, !at.front_side));
    const vec3 wo = at.shading.to_local(-direction);
    path.position = at.position;
    parts_.clear();
    if (vertex == 0)
        list_first_parts(shared, path, whole,
                         left_out_.clamped.empty() ? 0 : 1 - std::min(sqr(hit.t) / clamp_sq_m2_, 1.0f));
    else
        list_parts(shared, path, whole);
    float total = 0;
    for (const Part& part : parts_) total += part.weight;
    const vec2 choice = sampler.sample_2d(key, sample_set(vertex + 1, VertexSet::Lobe));
    float below = 0;  // of the choice by which part the path goes on
    for (const Part& part : parts_) {
        const float chance = part.weight > 0 ? part.weight / total : 0.0f;
        Path by_part = path;
        by_part.throughput *= part.share;
        by_part.narrow = part.narrow;
        by_part.blind = part.blind;
        by_part.lit_normal = lit_normal_of(part.bsdf, at);
        if (!part.blind && part.bsdf.has_non_delta()) {
            sample_light(shared, sampler, key, vertex, by_part, at, part.bsdf, wo, chance);
            if (shared.caustics && path.left > 0)
                add(path.point, part.narrow,
                    by_part.throughput * shared.caustics->radiance(at, part.bsdf, wo, path.left, neighbours_));
        }
        if (choice.y >= below && choice.y < below + chance)
            leave(sampler, key, vertex, by_part, at, part, wo, chance, {choice.x, (choice.y - below) / chance});
        below += chance;
    }
}

/// Adds the light that a path on from y meets at its ray's end.
void ClampRepayment::add_light_met(const RepaymentScene& shared, const Path& path, const Hit& hit,
                                   const vec3& direction) {
    Rgb radiance(0);
    float light_pdf = 0;
    if (!hit.valid()) {
        if (!shared.eye.scene.environment) return;
        radiance = shared.eye.lights.environment_radiance(direction);
        if (!path.delta) light_pdf = shared.eye.lights.pdf_environment(path.position, path.lit_normal, direction);
    } else {
        const ShadingPoint met = make_shading_point(shared.eye.scene, hit, direction);
        radiance = emitted_radiance(shared.eye.scene, {hit.instance, hit.triangle, hit.u, hit.v}, met.front_side);
        if (!path.delta && !is_black(radiance))
            light_pdf = shared.eye.lights.pdf_triangle(path.position, path.lit_normal, hit.instance, hit.triangle,
                                                       direction, hit.t);
    }
    if (!is_black(radiance))
        add(path.point, path.narrow,
            path.throughput * radiance * (path.delta ? 1.0f : power_heuristic(path.pdf_sa, light_pdf)));
}

/// Draws the path's next ray by that part; `chance`: for it to have come to that. `choice`: of a lobe, and of roulette.
void ClampRepayment::leave(const PassSampler& sampler, uint32_t key, uint32_t vertex, const Path& path,
                           const ShadingPoint& at, const Part& part, const vec3& wo, float chance, const vec2& choice) {
    const BsdfSample next =
        part.bsdf.sample(wo, choice.x, sampler.sample_2d(key, sample_set(vertex + 1, VertexSet::Direction)));
    if (!next.valid()) return;
    Path& on = batch_.next_path();
    on = path;
    on.throughput *= next.weight / chance;
    on.pdf_sa = next.pdf_sa * chance;
    on.delta = next.delta;
    if (next.refraction) on.media.cross(at.material, at.front_side);
    if (vertex >= ROULETTE_START) {
        const float survival = std::min(max_component(on.throughput) * kInvPi, ROULETTE_MOST_SURVIVAL);
        if (!(choice.y < survival)) return;
        on.throughput /= survival;
    }
    const vec3 w = at.shading.to_world(next.wi);
    batch_.next_ray() = {ray_origin(at, w), w, kInfinity};
    batch_.keep_next(key);
}

/// `goes_on`: chance for the path on to be drawn by that BSDF, which may meet the same light.
void ClampRepayment::sample_light(const RepaymentScene& shared, const PassSampler& sampler, uint32_t key,
                                  uint32_t vertex, const Path& path, const ShadingPoint& at, const Bsdf& bsdf,
                                  const vec3& wo, float goes_on) {
    LightSample light;
    const float choice = sampler.sample_2d(key, sample_set(vertex, VertexSet::LightChoiceAndRoulette)).x;
    if (!shared.eye.lights.sample(path.position, path.lit_normal, choice,
                                  sampler.sample_2d(key, sample_set(vertex, VertexSet::LightPoint)), light))
        return;
    const BsdfValue f = bsdf.evaluate(wo, at.shading.to_local(light.wi));
    if (is_black(f.f_cos)) return;
    const float weight = light.delta || !(goes_on > 0) ? 1.0f : power_heuristic(light.pdf_sa, goes_on * f.pdf_sa);
    shadows_.add(light.shadow_ray(ray_origin(at, light.wi)),
                 {path.throughput * f.f_cos * light.radiance_over_pdf * weight, path.point, path.narrow});
}

}  // namespace photond
