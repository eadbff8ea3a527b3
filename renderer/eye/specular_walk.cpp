#include "renderer/eye/specular_walk.h"

#include <algorithm>
#include <cassert>

#include "renderer/eye/eye_contributions.h"
#include "renderer/eye/eye_vertex.h"
#include "renderer/transport/hit_prefetch.h"
#include "renderer/transport/roulette_shared.h"

namespace photond {

namespace {

/// Shadow rays of a batch: as many light samples as a vertex may have fit in, and one of each of a tile's paths.
size_t shadow_batch(size_t paths) { return std::max<size_t>(SpecularWalk::kMostLightSamples, paths); }

}  // namespace

SpecularWalk::SpecularWalk(uint32_t tile_side) {
    const size_t paths = size_t{tile_side} * tile_side;
    for (auto* rays : {&rays_, &next_rays_}) rays->resize(paths);
    for (auto* states : {&paths_, &next_paths_}) states->resize(paths);
    for (auto* keys : {&keys_, &next_keys_}) keys->resize(paths);
    hits_.resize(paths);
    for (auto* order : {&lambert_, &general_}) order->reserve(paths);
    lambert_points_.reserve(paths);
    points_.reserve(paths);
    for (Numbers* numbers : {&light_point_, &light_choice_, &roulette_, &direction_, &lobe_})
        numbers->x.resize(paths), numbers->y.resize(paths);
    shadow_rays_.resize(shadow_batch(paths));
    pending_.resize(shadow_batch(paths));
    occluded_.resize(shadow_batch(paths));
}

uint64_t SpecularWalk::bytes_per_thread(uint32_t tile_side) {
    const size_t paths = size_t{tile_side} * tile_side;
    return paths * (2 * sizeof(Ray) + sizeof(Hit) + 2 * sizeof(EyePath) + 4 * sizeof(uint32_t) +
                    sizeof(LambertVisiblePoint) + sizeof(VisiblePoint) + 10 * sizeof(float)) +
           shadow_batch(paths) * (sizeof(Ray) + sizeof(PendingLight) + sizeof(uint8_t));
}

void SpecularWalk::trace_tile(const EyeScene& shared, const WalkSettings& settings, const WalkSamplers& samplers,
                              const Tile& tile, PassImage& image, Counts& counts, WalkSeconds& seconds,
                              const CancelToken& cancel, VisiblePointSink& sink) {
    const Pass pass{shared, settings, samplers, image, counts};
    ThreadLaps laps;
    count_ = tile.pixels();
    assert(count_ <= paths_.size() && "the tile is no larger than was said");
    start_eye_paths(shared, samplers.path, tile, {rays_.data(), count_}, {paths_.data(), count_},
                    {keys_.data(), count_});
    for (size_t i = 0; i < count_; ++i) clear_pixel(image, paths_[i].pixel);

    for (vertex_ = 0; count_ > 0 && !cancel.cancelled(); ++vertex_) {
        shared.intersector.closest_hits({rays_.data(), count_}, {hits_.data(), count_},
                                        vertex_ == 0 ? Coherence::Coherent : Coherence::Incoherent);
        (vertex_ == 0 ? counts.camera_rays : counts.bounce_rays) += count_;
        if (vertex_ == 0) laps.lap(seconds.camera);

        sort_hits(pass);
        draw_numbers(pass);
        next_count_ = 0;
        lambert_points_.clear();
        points_.clear();
        shade_lambert(pass);
        shade_general(pass);
        next_paths_.swap(paths_);
        next_rays_.swap(rays_);
        next_keys_.swap(keys_);
        count_ = next_count_;
        trace_shadow_rays(pass);
        laps.lap(vertex_ == 0 ? seconds.direct : seconds.indirect);

        if (lambert_points_.empty() && points_.empty()) continue;
        sink.take(lambert_points_, points_);
        laps.lap(seconds.points);
    }
}

/// Ends the paths that met nothing, takes what solids on the way absorbed, and tells the others apart.
void SpecularWalk::sort_hits(const Pass& pass) {
    const EyeScene& shared = pass.shared;
    lambert_.clear();
    general_.clear();
    for (uint32_t i = 0; i < count_; ++i) {
        const Hit& hit = hits_[i];
        EyePath& path = paths_[i];
        path.throughput *= shared.absorption.transmittance(path.media, hit.t);
        if (!hit.valid()) {
            add_environment(pass.image, shared, path, rays_[i].direction);
            continue;
        }
        prefetch_index(shared.scene, hit);
        (shared.shading[hit.instance].lambert ? lambert_ : general_).push_back(i);
    }
}

void SpecularWalk::draw_numbers(const Pass& pass) {
    const std::span<const uint32_t> keys(keys_.data(), count_);
    const auto draw = [&](const PassSampler& sampler, VertexSet set, Numbers& numbers) {
        sampler.sample_2d(keys, sample_set(vertex_, set), {numbers.x.data(), count_}, {numbers.y.data(), count_});
    };
    const WalkSamplers& samplers = pass.samplers;
    draw(samplers.light_samples[0], VertexSet::LightPoint, light_point_);
    draw(samplers.light_samples[0], VertexSet::LightChoiceAndRoulette, light_choice_);
    if (general_.empty()) return;
    draw(samplers.path, VertexSet::LightChoiceAndRoulette, roulette_);
    draw(samplers.path, VertexSet::Direction, direction_);
    draw(samplers.path, VertexSet::Lobe, lobe_);
}

WalkVertex SpecularWalk::decide(const Pass& pass, const EyePath& path, bool waits) {
    WalkVertex decided;
    if (pass.settings.guide) decided = pass.settings.guide->decide(path.throughput, path.eta_scale, waits);
    assert(decided.light_samples > 0 && decided.light_samples <= pass.samplers.light_samples.size());
    if (shadow_count_ + decided.light_samples > shadow_rays_.size()) trace_shadow_rays(pass);
    return decided;
}

/// Draws one of the point's light samples. False: it carries nothing.
bool SpecularWalk::draw_light(const Pass& pass, const LitPoint& point, uint32_t sample, LightSample& light) const {
    float choice = light_choice_.x[point.index];
    vec2 on_light(light_point_.x[point.index], light_point_.y[point.index]);
    if (sample > 0) {
        const PassSampler& sampler = pass.samplers.light_samples[sample];
        const uint32_t key = keys_[point.index];
        choice = sampler.sample_2d(key, sample_set(vertex_, VertexSet::LightChoiceAndRoulette)).x;
        on_light = sampler.sample_2d(key, sample_set(vertex_, VertexSet::LightPoint));
    }
    return pass.shared.lights.sample(point.position, point.lit_normal, choice, on_light, light);
}

/// Adds radiance of a light sample where the guide knows that it arrives; else, once its shadow ray from `origin` says
/// so.
void SpecularWalk::add_light(const Pass& pass, LitPoint& point, const LightSample& light, const vec3& origin,
                             const Rgb& radiance) {
    if (pass.settings.guide && point.judged != light.source) {
        point.judged = light.source;
        point.seen = pass.settings.guide->light_seen(point.position, point.geometric_normal, light.source);
    }
    switch (point.seen) {
        case LightSeen::Whole:
            (point.indirect ? pass.image.indirect : pass.image.direct)[point.pixel] += radiance;
            break;
        case LightSeen::Nothing: break;
        case LightSeen::Unknown:
            shadow_rays_[shadow_count_] = light.shadow_ray(origin);
            pending_[shadow_count_++] = {radiance, point.pixel, point.indirect};
    }
}

void SpecularWalk::shade_general(const Pass& pass) {
    for (size_t k = 0; k < general_.size(); ++k) {
        prefetch_ahead(pass.shared.scene, hits_, general_, k);
        const uint32_t i = general_[k];
        if (shade_vertex(pass, i)) next_keys_[next_count_++] = keys_[i];
    }
}

/// Adds what path i finds at the end of its ray, draws light samples there, leaves its rough part as a visible point
/// and follows its specular part. False: the path ends, and what stands in the place of the next path does not count.
bool SpecularWalk::shade_vertex(const Pass& pass, uint32_t i) {
    const EyeScene& shared = pass.shared;
    EyePath& path = next_paths_[next_count_];
    path = paths_[i];
    // Only specular parts are followed: their density is what the path's pdf_sa says, and light samples are weighed by.
    EyeVertex met;
    if (!meet_surface(shared, path, vertex_, hits_[i], rays_[i], pass.image, met)) return false;
    const auto& [surface, bsdf, wo] = met;
    const float threshold = pass.settings.glossy_threshold;
    const Bsdf specular = bsdf.specular_part(threshold), rough = bsdf.rough_part(threshold);

    const bool waits = rough.scatters() && path.scatterings + 2 <= shared.max_scatterings;
    const WalkVertex decided = decide(pass, path, waits);
    if (bsdf.has_non_delta()) {
        // The specular part's share of light samples competes with the direction that the path goes on to, the rough
        // part's with the rays that the method will draw.
        const auto samples = static_cast<float>(decided.light_samples),
                   rays = static_cast<float>(decided.competing_rays);
        LitPoint point{surface.position, surface.geometric_normal, path.lit_normal, i,
                       path.pixel,       path.scatterings > 0};
        for (uint32_t s = 0; s < decided.light_samples; ++s) {
            LightSample light;
            if (!draw_light(pass, point, s, light)) continue;
            const vec3 wi = surface.shading.to_local(light.wi);
            const auto weighed = [&](const BsdfValue& f, float others) {
                return light.delta ? f.f_cos : power_heuristic(samples * light.pdf_sa, others * f.pdf_sa) * f.f_cos;
            };
            const Rgb f_cos = weighed(specular.evaluate(wo, wi), 1) + weighed(rough.evaluate(wo, wi), rays);
            if (is_black(f_cos)) continue;
            add_light(pass, point, light, ray_origin(surface, light.wi),
                      path.throughput * f_cos * light.radiance_over_pdf / samples);
        }
    }
    if (waits)
        points_.push_back({surface, rough, wo, path.throughput, path.eta_scale, path.pixel, path.scatterings,
                           path.media, keys_[i], vertex_, path.lit_normal});

    const bool on = leave_surface(path, surface, specular.sample(wo, lobe_.x[i], {direction_.x[i], direction_.y[i]}),
                                  vertex_ + 1 >= ROULETTE_START, roulette_.y[i], pass.image, next_rays_[next_count_]);
    path.pdf_sa /= static_cast<float>(decided.light_samples);
    return on;
}

void SpecularWalk::trace_shadow_rays(const Pass& pass) {
    pass.shared.intersector.occluded({shadow_rays_.data(), shadow_count_}, {occluded_.data(), shadow_count_},
                                     vertex_ == 0 ? Coherence::Coherent : Coherence::Incoherent);
    pass.counts.shadow_rays += shadow_count_;
    for (size_t i = 0; i < shadow_count_; ++i) {
        if (occluded_[i]) continue;
        const PendingLight& light = pending_[i];
        (light.indirect ? pass.image.indirect : pass.image.direct)[light.pixel] += light.radiance;
    }
    shadow_count_ = 0;
}

}  // namespace photond
