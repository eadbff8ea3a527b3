#include "renderer/methods/photon_mapping/eye_pass.h"

#include "renderer/methods/eye_vertex.h"
#include "renderer/transport/hit_prefetch.h"

namespace photond {

namespace {

/// Vertices after which Russian roulette may end a path through specular parts.
constexpr uint32_t kRouletteStart = 4;

}  // namespace

EyePass::EyePass()
    : rays_(kPaths),
      next_rays_(kPaths),
      paths_(kPaths),
      next_paths_(kPaths),
      keys_(kPaths),
      next_keys_(kPaths),
      hits_(kPaths),
      shadow_rays_(kShadowRays),
      pending_(kShadowRays),
      occluded_(kShadowRays) {
    order_.reserve(kPaths);
    gather_points_.reserve(kPaths);
    for (Numbers* numbers : {&roulette_, &direction_, &lobe_}) numbers->x.resize(kPaths), numbers->y.resize(kPaths);
}

uint64_t EyePass::bytes_per_thread() {
    return kPaths * (2 * sizeof(Ray) + sizeof(Hit) + 2 * sizeof(EyePath) + 3 * sizeof(uint32_t) + sizeof(GatherPoint) +
                     6 * sizeof(float)) +
           kShadowRays * (sizeof(Ray) + sizeof(PendingLight) + sizeof(uint8_t)) + FinalGather::bytes_per_thread();
}

void EyePass::trace_tile(const PhotonMappingScene& shared, const PassMaps& maps, const PassSamplers& samplers,
                         const Tile& tile, PassImage& image, Counts& counts, EyePassSeconds& seconds,
                         const CancelToken& cancel) {
    ThreadLaps laps;
    count_ = tile.pixels();
    start_eye_paths(shared, samplers.path, tile, {rays_.data(), count_}, {paths_.data(), count_},
                    {keys_.data(), count_});
    for (size_t i = 0; i < count_; ++i) clear_pixel(image, paths_[i].pixel);

    for (uint32_t vertex = 0; count_ > 0; ++vertex) {
        shared.intersector.closest_hits({rays_.data(), count_}, {hits_.data(), count_},
                                        vertex == 0 ? Coherence::Coherent : Coherence::Incoherent);
        (vertex == 0 ? counts.camera_rays : counts.bounce_rays) += count_;
        if (vertex == 0) laps.lap(seconds.camera);

        sort_hits(shared, image);
        draw_numbers(samplers.path, vertex);
        next_count_ = 0;
        gather_points_.clear();
        for (size_t k = 0; k < order_.size(); ++k) {
            prefetch_ahead(shared.scene, hits_, order_, k);
            const uint32_t i = order_[k];
            if (shade_vertex(shared, maps, samplers.light, vertex, i, image, counts))
                next_keys_[next_count_++] = keys_[i];
        }
        next_paths_.swap(paths_);
        next_rays_.swap(rays_);
        next_keys_.swap(keys_);
        count_ = next_count_;
        trace_shadow_rays(shared, vertex, image, counts);
        laps.lap(vertex == 0 ? seconds.direct : seconds.indirect);

        look_up_maps(shared, maps, image);
        if (shared.final_gather())
            final_gather_.gather(shared, maps, samplers.gather, gather_points_, image, counts, cancel);
        laps.lap(seconds.gather);
    }
}

/// Ends the paths that met nothing and takes what solids on the way absorbed.
void EyePass::sort_hits(const PhotonMappingScene& shared, PassImage& image) {
    order_.clear();
    for (uint32_t i = 0; i < count_; ++i) {
        const Hit& hit = hits_[i];
        EyePath& path = paths_[i];
        path.throughput *= shared.absorption.transmittance(path.media, hit.t);
        if (!hit.valid()) {
            add_environment(image, shared, path, rays_[i].direction);
            continue;
        }
        prefetch_index(shared.scene, hit);
        order_.push_back(i);
    }
}

void EyePass::draw_numbers(const PassSampler& sampler, uint32_t vertex) {
    const std::span<const uint32_t> keys(keys_.data(), count_);
    const auto draw = [&](VertexSet set, Numbers& numbers) {
        sampler.sample_2d(keys, sample_set(vertex, set), {numbers.x.data(), count_}, {numbers.y.data(), count_});
    };
    draw(VertexSet::LightChoiceAndRoulette, roulette_);
    draw(VertexSet::Direction, direction_);
    draw(VertexSet::Lobe, lobe_);
}

/// Adds what path i finds at the end of its ray, draws light samples there (A), leaves its rough part to the maps (C,
/// D) and follows its specular part (B). False: the path ends, and what stands in the place of the next path does not
/// count.
bool EyePass::shade_vertex(const PhotonMappingScene& shared, const PassMaps& maps, const SplitSamplers& light_samplers,
                           uint32_t vertex, uint32_t i, PassImage& image, Counts& counts) {
    EyePath& path = next_paths_[next_count_];
    path = paths_[i];
    // Only specular parts are followed: their density is what the path's pdf_sa says, and light samples are weighed by.
    EyeVertex met;
    if (!meet_surface(shared, path, vertex, hits_[i], rays_[i], image, met)) return false;
    const auto& [surface, bsdf, wo] = met;
    const float threshold = shared.params.glossy_threshold;
    const Bsdf specular = bsdf.specular_part(threshold), rough = bsdf.rough_part(threshold);

    const bool gathers = rough.scatters() && path.scatterings + 2 <= shared.max_scatterings;
    const auto split = [&](uint32_t all) { return split_of(all, path.throughput, path.eta_scale); };
    const uint32_t light_samples = split(shared.params.most_light_samples());
    const uint32_t gather_rays = gathers ? split(shared.params.gather_rays) : 0;
    if (bsdf.has_non_delta()) {
        if (shadow_count_ + light_samples > kShadowRays) trace_shadow_rays(shared, vertex, image, counts);
        const uint32_t competing = FinalGather::samples_lights(shared.params) ? gather_rays : 0;
        sample_lights(shared, maps, light_samplers, {surface, specular, rough, wo, light_samples, competing}, path,
                      keys_[i], vertex, image);
    }
    if (gathers)
        gather_points_.push_back({surface, rough, wo, path.throughput, path.eta_scale, path.pixel, path.scatterings,
                                  path.media, FinalGather::key(keys_[i], vertex), gather_rays, light_samples,
                                  path.lit_normal});

    const bool on = leave_surface(path, surface, specular.sample(wo, lobe_.x[i], {direction_.x[i], direction_.y[i]}),
                                  vertex + 1 >= kRouletteStart, roulette_.y[i], image, next_rays_[next_count_]);
    path.pdf_sa /= static_cast<float>(light_samples);
    return on;
}

/// Draws the point's light samples. The specular part's share of them competes with the direction that the path goes on
/// to, the rough part's with gather rays.
void EyePass::sample_lights(const PhotonMappingScene& shared, const PassMaps& maps, const SplitSamplers& samplers,
                            const LitPoint& point, const EyePath& path, uint32_t key, uint32_t vertex,
                            PassImage& image) {
    const ShadingPoint& surface = point.surface;
    const auto samples = static_cast<float>(point.samples), rays = static_cast<float>(point.gather_rays);
    std::vector<Rgb>& layer = path.scatterings > 0 ? image.indirect : image.direct;
    // What the shadow photons said of the last light: it is the same here for each of its samples.
    std::optional<uint32_t> judged;
    LightSeen seen = LightSeen::Unknown;
    for (uint32_t i = 0; i < point.samples; ++i) {
        const float choice = samplers[i].sample_2d(key, sample_set(vertex, VertexSet::LightChoiceAndRoulette)).x;
        const vec2 on_light = samplers[i].sample_2d(key, sample_set(vertex, VertexSet::LightPoint));
        LightSample light;
        if (!shared.lights.sample(path.position, path.lit_normal, choice, on_light, light)) continue;
        const vec3 wi = surface.shading.to_local(light.wi);
        const BsdfValue by_specular = point.specular.evaluate(point.wo, wi),
                        by_rough = point.rough.evaluate(point.wo, wi);
        const auto weighed = [&](const BsdfValue& f, float others) {
            return light.delta ? f.f_cos : power_heuristic(samples * light.pdf_sa, others * f.pdf_sa) * f.f_cos;
        };
        const Rgb f_cos = weighed(by_specular, 1) + weighed(by_rough, rays);
        if (is_black(f_cos)) continue;
        const Rgb radiance = path.throughput * f_cos * light.radiance_over_pdf / samples;
        if (judged != light.source) {
            judged = light.source;
            seen = light_seen(maps, surface, light, neighbours_);
        }
        switch (seen) {
            case LightSeen::Whole: layer[path.pixel] += radiance; break;
            case LightSeen::Nothing: break;
            case LightSeen::Unknown:
                shadow_rays_[shadow_count_] = light.shadow_ray(ray_origin(surface, light.wi));
                pending_[shadow_count_++] = {radiance, path.pixel, path.scatterings > 0};
        }
    }
}

void EyePass::trace_shadow_rays(const PhotonMappingScene& shared, uint32_t vertex, PassImage& image, Counts& counts) {
    shared.intersector.occluded({shadow_rays_.data(), shadow_count_}, {occluded_.data(), shadow_count_},
                                vertex == 0 ? Coherence::Coherent : Coherence::Incoherent);
    counts.shadow_rays += shadow_count_;
    for (size_t i = 0; i < shadow_count_; ++i) {
        if (occluded_[i]) continue;
        const PendingLight& light = pending_[i];
        (light.indirect ? image.indirect : image.direct)[light.pixel] += light.radiance;
    }
    shadow_count_ = 0;
}

/// Light of the maps that the rough parts of this vertex scatter.
void EyePass::look_up_maps(const PhotonMappingScene& shared, const PassMaps& maps, PassImage& image) {
    for (const GatherPoint& point : gather_points_) {
        const uint32_t most = shared.photon_scatterings(point.scatterings + 1);
        const RadianceEstimate caustic =
            estimate_caustic(shared, maps, point.surface, point.rough, point.wo, most, neighbours_);
        RadianceEstimate global;
        if (!shared.final_gather())
            global = estimate_global(shared, maps, point.surface, point.rough, point.wo, most, neighbours_);
        image.indirect[point.pixel] += point.throughput * (caustic.radiance + global.radiance);
        if (!image.caustic.empty() && point.scatterings == 0)
            image.caustic[point.pixel] += point.throughput * caustic.delta_radiance;
        if (!image.photon_count.empty())
            image.photon_count[point.pixel] += static_cast<float>(caustic.photons + global.photons);
    }
}

}  // namespace photond
