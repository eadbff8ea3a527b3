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

SpecularWalk::SpecularWalk(uint32_t tile_side)
    : batch_(size_t{tile_side} * tile_side),
      light_point_(batch_.room()),
      light_choice_(batch_.room()),
      roulette_(batch_.room()),
      direction_(batch_.room()),
      lobe_(batch_.room()),
      shadows_(shadow_batch(batch_.room())) {
    lambert_points_.reserve(batch_.room());
    points_.reserve(batch_.room());
}

uint64_t SpecularWalk::bytes_per_thread(uint32_t tile_side) {
    const size_t paths = size_t{tile_side} * tile_side;
    return EyeBatch::bytes_for(paths) +
           paths * (sizeof(LambertVisiblePoint) + sizeof(VisiblePoint) + 10 * sizeof(float)) +
           ShadowBatch<WaitingLight>::bytes_for(shadow_batch(paths));
}

void SpecularWalk::trace_tile(const EyeScene& shared, const WalkSettings& settings, const WalkSamplers& samplers,
                              const Tile& tile, PassImage& image, Counts& counts, EyeSeconds& seconds,
                              const CancelToken& cancel, VisiblePointSink& sink) {
    const Pass pass{shared, settings, samplers, image, counts};
    ThreadLaps laps;
    batch_.start(shared, samplers.path, tile, image);

    for (vertex_ = 0; batch_.count > 0 && !cancel.cancelled(); ++vertex_) {
        batch_.trace_rays(shared, vertex_, counts);
        if (vertex_ == 0) laps.lap(seconds.camera);

        batch_.sort_hits(shared, image);
        draw_numbers(pass);
        lambert_points_.clear();
        points_.clear();
        shade_lambert(pass);
        shade_general(pass);
        batch_.advance();
        trace_shadow_rays(pass);
        laps.lap(vertex_ == 0 ? seconds.direct : seconds.indirect);

        if (lambert_points_.empty() && points_.empty()) continue;
        sink.take(lambert_points_, points_);
        laps.lap(seconds.points);
    }
}

VisiblePoint SpecularWalk::general(const LambertVisiblePoint& point) const {
    const EyePath& path = this->path(point);
    VisiblePoint general;
    general.surface.position = point.position;
    general.surface.geometric_normal = point.geometric_normal;
    general.surface.smooth_normal = point.normal;
    general.surface.shading = Frame(point.normal);
    general.rough = Bsdf::lambert(general.surface.shading.to_local(point.geometric_normal), point.reflectance);
    general.wo = vec3(0, 0, 1);  // to a Lambert reflector all directions above the horizon are one
    general.throughput = path.throughput;
    general.eta_scale = path.eta_scale;
    general.pixel = point.pixel;
    general.scatterings = point.scatterings;
    general.media = path.media;
    general.path_key = path_key(point);
    general.vertex = vertex_;
    general.lit_normal = point.normal;
    return general;
}

void SpecularWalk::draw_numbers(const Pass& pass) {
    const std::span<const uint32_t> keys = batch_.keys_under_way();
    const WalkSamplers& samplers = pass.samplers;
    light_point_.draw(samplers.light_samples[0], sample_set(vertex_, VertexSet::LightPoint), keys);
    light_choice_.draw(samplers.light_samples[0], sample_set(vertex_, VertexSet::LightChoiceAndRoulette), keys);
    if (batch_.general.empty()) return;
    roulette_.draw(samplers.path, sample_set(vertex_, VertexSet::LightChoiceAndRoulette), keys);
    direction_.draw(samplers.path, sample_set(vertex_, VertexSet::Direction), keys);
    lobe_.draw(samplers.path, sample_set(vertex_, VertexSet::Lobe), keys);
}

WalkVertex SpecularWalk::decide(const Pass& pass, const EyePath& path, bool waits) {
    WalkVertex decided;
    if (pass.settings.guide) decided = pass.settings.guide->decide(path.throughput, path.eta_scale, waits);
    assert(decided.light_samples > 0 && decided.light_samples <= pass.samplers.light_samples.size());
    if (!shadows_.has_room_for(decided.light_samples)) trace_shadow_rays(pass);
    return decided;
}

/// Draws one of the point's light samples. False: it carries nothing.
bool SpecularWalk::draw_light(const Pass& pass, const LitPoint& point, uint32_t sample, LightSample& light) const {
    float choice = light_choice_.x[point.index];
    vec2 on_light(light_point_.x[point.index], light_point_.y[point.index]);
    if (sample > 0) {
        const PassSampler& sampler = pass.samplers.light_samples[sample];
        const uint32_t key = batch_.keys[point.index];
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
            (point.indirect ? pass.image.of<Layer::Indirect>() : pass.image.of<Layer::Direct>())[point.pixel] +=
                radiance;
            break;
        case LightSeen::Nothing: break;
        case LightSeen::Unknown: shadows_.add(light.shadow_ray(origin), {radiance, point.pixel, point.indirect}); break;
    }
}

void SpecularWalk::shade_general(const Pass& pass) {
    for (size_t k = 0; k < batch_.general.size(); ++k) {
        prefetch_ahead(pass.shared.scene, batch_.hits, batch_.general, k);
        const uint32_t i = batch_.general[k];
        if (shade_vertex(pass, i)) batch_.keep_next(batch_.keys[i]);
    }
}

/// Adds what path i finds at the end of its ray, draws light samples there, leaves its rough part as a visible point
/// and follows its specular part. False: the path ends, and what stands in the place of the next path does not count.
bool SpecularWalk::shade_vertex(const Pass& pass, uint32_t i) {
    const EyeScene& shared = pass.shared;
    EyePath& path = batch_.next_path();
    path = batch_.paths[i];
    // Only specular parts are followed: their density is what the path's pdf_sa says, and light samples are weighed by.
    EyeVertex met;
    if (!meet_surface(shared, path, vertex_, batch_.hits[i], batch_.rays[i], pass.image, met)) return false;
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
                           path.media, batch_.keys[i], vertex_, path.lit_normal});

    const bool on = leave_surface(path, surface, specular.sample(wo, lobe_.x[i], {direction_.x[i], direction_.y[i]}),
                                  vertex_ + 1 >= ROULETTE_START, roulette_.y[i], pass.image, batch_.next_ray());
    path.pdf_sa /= static_cast<float>(decided.light_samples);
    return on;
}

void SpecularWalk::trace_shadow_rays(const Pass& pass) {
    add_unshadowed(shadows_, pass.shared, vertex_, pass.image, pass.counts);
}

}  // namespace photond
