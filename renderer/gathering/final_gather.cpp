#include "renderer/gathering/final_gather.h"

#include <algorithm>

#include "renderer/core/morton.h"
#include "renderer/eye/eye_contributions.h"
#include "renderer/transport/hit_prefetch.h"
#include "renderer/transport/roulette_shared.h"

namespace photond {

namespace {

/// Instead of a number for Russian roulette: none.
constexpr float kCertain = -1;

}  // namespace

FinalGather::FinalGather() : keys_(kRays), direction_x_(kRays), direction_y_(kRays), lobe_x_(kRays), lobe_y_(kRays) {
    order_.reserve(kPaths);
    indices_.reserve(kPaths);
}

uint64_t FinalGather::bytes_per_thread() {
    return PathBatch<GatherPath>::bytes_for(kPaths) + ShadowBatch<WaitingRadiance>::bytes_for(kPaths) +
           kPaths * (sizeof(uint64_t) + sizeof(uint32_t)) + kRays * (sizeof(uint32_t) + 4 * sizeof(float));
}

void FinalGather::gather(const GatherPass& pass, std::span<const GatherPoint> points, const CancelToken& cancel) {
    while (!points.empty() && !cancel.cancelled()) {
        size_t batch = 0;
        for (uint32_t rays = 0; batch < points.size() && rays + points[batch].rays <= kRays; ++batch)
            rays += points[batch].rays;
        gather_batch(pass, points.first(batch));
        points = points.subspan(batch);
    }
}

void FinalGather::gather_batch(const GatherPass& pass, std::span<const GatherPoint> points) {
    const GatheringScene& shared = pass.shared;
    start_rays(pass, points);
    for (uint32_t vertex = 1; batch_.count > 0; ++vertex) {
        batch_.find_hits(shared.intersector, Coherence::Incoherent);
        pass.counts.bounce_rays += batch_.count;
        sort_hits(shared, points, pass.image);
        for (size_t k = 0; k < indices_.size(); ++k) {
            prefetch_ahead(shared.scene, batch_.hits, indices_, k);
            shade(pass, points[batch_.paths[indices_[k]].point], vertex, indices_[k]);
        }
        batch_.advance();
        pass.counts.shadow_rays += shadows_.trace(
            shared.intersector, Coherence::Incoherent,
            [&](const WaitingRadiance& light) { pass.image.of<Layer::Indirect>()[light.pixel] += light.radiance; });
    }
}

void FinalGather::start_rays(const GatherPass& pass, std::span<const GatherPoint> points) {
    const GatheringScene& shared = pass.shared;
    const bool by_photons = shared.params.gather_sampling == GatherSampling::Photons;
    distributions_.clear();
    if (by_photons)
        for (const GatherPoint& point : points)
            distributions_.emplace_back(pass.maps.global, point.surface,
                                        shared.photon_scatterings(point.scatterings + 1), neighbours_);
    const bool lights = samples_lights(shared.params);
    batch_.count = 0;
    uint32_t most_rays = 0;
    for (const GatherPoint& point : points) most_rays = std::max(most_rays, point.rays);
    for (uint32_t ray = 0; ray < most_rays; ++ray) {
        // The points that have so many rays, and their numbers.
        indices_.clear();
        for (uint32_t p = 0; p < points.size(); ++p) {
            if (ray >= points[p].rays) continue;
            keys_[indices_.size()] = points[p].key;
            indices_.push_back(p);
        }
        const size_t n = indices_.size();
        pass.samplers[ray].sample_2d({keys_.data(), n}, sample_set(0, VertexSet::Direction), {direction_x_.data(), n},
                                     {direction_y_.data(), n});
        pass.samplers[ray].sample_2d({keys_.data(), n}, sample_set(0, VertexSet::Lobe), {lobe_x_.data(), n},
                                     {lobe_y_.data(), n});
        for (size_t k = 0; k < n; ++k) {
            const uint32_t p = indices_[k];
            const GatherPoint& point = points[p];
            const vec2 u(direction_x_[k], direction_y_[k]);
            BsdfSample next;
            if (by_photons && !point.rough.has_non_delta_transmission()) {
                const GatherDistribution::Sample drawn = distributions_[p].sample(point.rough, point.wo, lobe_x_[k], u);
                next.wi = drawn.wi;
                next.weight = drawn.weight;
                next.pdf_sa = drawn.pdf_sa;
            } else {
                next = point.rough.sample(point.wo, lobe_x_[k], u);
            }
            if (!next.valid() || is_black(next.weight)) continue;
            GatherPath& path = batch_.paths[batch_.count];
            path.throughput = next.weight;
            path.eta_scale = next.refraction ? sqr(next.eta) : 1.0f;
            path.point = p;
            path.scatterings = point.scatterings + 1;
            path.lights_only = false;
            path.light = {
                point.surface.position, point.lit_normal,
                lights ? next.pdf_sa * static_cast<float>(point.rays) / static_cast<float>(point.light_samples) : 0.0f};
            path.media = point.media;
            if (next.refraction) path.media.cross(point.surface.material, point.surface.front_side);
            const vec3 wi = point.surface.shading.to_world(next.wi);
            batch_.keys[batch_.count] = ray;
            batch_.rays[batch_.count++] = {ray_origin(point.surface, wi), wi, kInfinity};
        }
    }
}

/// Hits in the order of a curve that fills space: those that look at the same photons and triangles follow each other.
void FinalGather::sort_hits(const GatheringScene& shared, std::span<const GatherPoint> points, PassImage& image) {
    order_.clear();
    indices_.clear();
    for (uint32_t i = 0; i < batch_.count; ++i) {
        const Hit& hit = batch_.hits[i];
        if (hit.valid()) {
            prefetch_index(shared.scene, hit);
            const vec3 position = batch_.rays[i].origin + hit.t * batch_.rays[i].direction;
            order_.push_back(uint64_t{morton_code(shared.scene.bounds, position)} << 32 | i);
        } else if (shared.scene.environment && batch_.paths[i].light.pdf_sa > 0) {
            const vec3& wi = batch_.rays[i].direction;
            const GatherPath& path = batch_.paths[i];
            const float light_pdf = shared.lights.pdf_environment(path.light.position, path.light.lit_normal, wi);
            add_direct(image, points[path.point], path,
                       shared.absorption.transmittance(path.media, kInfinity) * shared.lights.environment_radiance(wi),
                       light_pdf);
        }
    }
    std::sort(order_.begin(), order_.end());
    for (const uint64_t entry : order_) indices_.push_back(static_cast<uint32_t>(entry));
}

/// Radiance of a light that a ray met, and that a light sample where the ray began finds with that density.
void FinalGather::add_direct(PassImage& image, const GatherPoint& origin, const GatherPath& path, const Rgb& radiance,
                             float light_pdf) {
    const float weight = power_heuristic(path.light.pdf_sa, light_pdf) / static_cast<float>(origin.rays);
    (path.scatterings == 1 ? image.of<Layer::Direct>() : image.of<Layer::Indirect>())[origin.pixel] +=
        weight * origin.throughput * path.throughput * radiance;
}

void FinalGather::shade(const GatherPass& pass, const GatherPoint& origin, uint32_t vertex, uint32_t i) {
    const GatheringScene& shared = pass.shared;
    const Scene& scene = shared.scene;
    PassImage& image = pass.image;
    GatherPath path = batch_.paths[i];
    const Hit& hit = batch_.hits[i];
    const Ray& ray = batch_.rays[i];
    const ShadingPoint surface = make_shading_point(scene, hit, ray.direction);
    if (scene.materials[surface.material].unlit) return;
    path.throughput *= shared.absorption.transmittance(path.media, hit.t);
    if (path.light.pdf_sa > 0 && scene.materials[surface.material].emissive()) {
        const Rgb emitted = emitted_radiance(scene, {hit.instance, hit.triangle, hit.u, hit.v}, surface.front_side);
        if (!is_black(emitted))
            add_direct(image, origin, path, emitted,
                       shared.lights.pdf_triangle(path.light.position, path.light.lit_normal, hit.instance,
                                                  hit.triangle, ray.direction, hit.t));
    }
    if (path.lights_only || path.scatterings >= shared.max_scatterings) return;

    const Bsdf bsdf = make_bsdf(scene, surface, path.media.outside_ior(scene, surface.material, !surface.front_side));
    const Bsdf rough = bsdf.is_lambert() ? bsdf : bsdf.rough_part(shared.params.glossy_threshold);
    const vec3 wo = surface.shading.to_local(-ray.direction);
    const uint32_t number = batch_.keys[i];
    const PassSampler& sampler = pass.samplers[number];
    const vec2 direction = sampler.sample_2d(origin.key, sample_set(vertex, VertexSet::Direction));
    const Rgb to_pixel = origin.throughput * path.throughput * (1 / static_cast<float>(origin.rays));

    if (rough.scatters()) {
        const vec2 choice = sampler.sample_2d(origin.key, sample_set(vertex, VertexSet::LightChoiceAndRoulette));
        const vec3 lit_normal = rough.has_non_delta_transmission() ? vec3(0) : surface.shading.normal;
        // One ray by f_d beside one light sample.
        const bool looks_for_lights = shared.lights_can_be_met && !rough.is_diffuse();
        LightSample light;
        if (shared.lights.sample(surface.position, lit_normal, choice.x,
                                 sampler.sample_2d(origin.key, sample_set(vertex, VertexSet::LightPoint)), light)) {
            const BsdfValue f = rough.evaluate(wo, surface.shading.to_local(light.wi));
            const float weight = looks_for_lights && !light.delta ? power_heuristic(light.pdf_sa, f.pdf_sa) : 1.0f;
            const Rgb radiance = weight * to_pixel * f.f_cos * light.radiance_over_pdf;
            if (!is_black(radiance)) {
                switch (light_seen(pass.maps, surface.position, surface.geometric_normal, light.source, neighbours_)) {
                    case LightSeen::Whole: image.of<Layer::Indirect>()[origin.pixel] += radiance; break;
                    case LightSeen::Nothing: break;
                    case LightSeen::Unknown:
                        shadows_.add(light.shadow_ray(ray_origin(surface, light.wi)), {radiance, origin.pixel});
                        break;
                }
            }
        }
        // A ray shorter than the radius of the lookup at its end begins where the disc is: in a corner, where density
        // is smeared and lost at the edge, and where all short rays see the same error. It goes on for one bounce.
        const RayEnd end{surface,
                         rough,
                         wo,
                         to_pixel,
                         origin.pixel,
                         shared.photon_scatterings(path.scatterings + 1),
                         disc_turn(direction),
                         vertex == 1 ? hit.t : kInfinity};
        const bool goes_on = !pass.ends.add(end, image);
        if (goes_on || looks_for_lights) {
            const BsdfSample next = rough.sample(wo, choice.y, direction);
            if (GatherPath* const followed = follow(path, number, surface, next, kCertain)) {
                followed->lights_only = !goes_on;
                followed->light = {surface.position, lit_normal, looks_for_lights ? next.pdf_sa : 0.0f};
            }
        }
    }
    if (bsdf.is_lambert()) return;

    const Bsdf specular = bsdf.specular_part(shared.params.glossy_threshold);
    if (!specular.scatters()) return;
    // Many rays are averaged: roulette may end each from the start.
    const vec2 lobe = sampler.sample_2d(origin.key, sample_set(vertex, VertexSet::Lobe));
    follow(path, number, surface, specular.sample(wo, lobe.x, direction), lobe.y);
}

/// Goes on as sampled, unless Russian roulette with the number `roulette` ends the path; kCertain: it does not. Lights
/// that it meets do not count, unless the path returned is told so; null where it ended.
FinalGather::GatherPath* FinalGather::follow(const GatherPath& path, uint32_t ray, const ShadingPoint& surface,
                                             const BsdfSample& sample, float roulette) {
    if (!sample.valid()) return nullptr;
    GatherPath next = path;
    next.throughput *= sample.weight;
    if (sample.refraction) {
        next.eta_scale *= sqr(sample.eta);
        next.media.cross(surface.material, surface.front_side);
    }
    if (roulette != kCertain) {
        const float survival = std::min(max_component(next.throughput) * next.eta_scale, ROULETTE_MOST_SURVIVAL);
        if (!(roulette < survival)) return nullptr;
        next.throughput /= survival;
    }
    next.light = {};
    ++next.scatterings;
    const vec3 wi = surface.shading.to_world(sample.wi);
    GatherPath& followed = batch_.next_path();
    followed = next;
    batch_.next_ray() = {ray_origin(surface, wi), wi, kInfinity};
    batch_.keep_next(ray);
    return &followed;
}

}  // namespace photond
