#pragma once
// Lamps that narrow gloss shows: at each visible point a ray drawn by its lobes, beside the light sample, both weighed
// by multiple importance sampling. Of the environment neither brings anything: EnvironmentLight does.

#include "renderer/eye/specular_walk.h"

namespace photond {

/// Whether lobes draw rays: where no rough surface is glossy light samples do well alone, and points need none.
inline bool draws_lamp_rays(const Needs& needs) { return needs.area_lights && needs.glossy; }

/// For the walk: light samples of lamps alone, weighed against those rays.
class LampsAlone final : public WalkGuide {
public:
    explicit LampsAlone(const Scene& scene)
        : environment_(light_source_of_environment(scene)), rays_(draws_lamp_rays(scene.needs) ? 1 : 0) {}

    WalkVertex decide(const Rgb&, float, bool) const override { return {.competing_rays = rays_}; }
    LightSeen light_seen(const vec3&, const vec3&, uint32_t source) override {
        return source == environment_ ? LightSeen::Nothing : LightSeen::Unknown;
    }

private:
    const uint32_t environment_, rays_;
};

/// Draws the rays of the points that a walk leaves, and hands the points on. One thread's, of one tile.
class LampRays final : public VisiblePointSink {
public:
    /// Borrows all. `next` may be null. `walk` is the one that will call take(), by the numbers of `sampler`.
    LampRays(const EyeScene& eye, const SpecularWalk& walk, const PassSampler& sampler, PassImage& image,
             Counts& counts, VisiblePointSink* next)
        : eye_(eye), walk_(walk), sampler_(sampler), image_(image), counts_(counts), next_(next) {}

    void take(std::span<const LambertVisiblePoint> lambert, std::span<const VisiblePoint> others) override;

private:
    Rgb lamp_met(const VisiblePoint& point) const;

    const EyeScene& eye_;
    const SpecularWalk& walk_;
    const PassSampler& sampler_;
    PassImage& image_;
    Counts& counts_;
    VisiblePointSink* const next_;
};

}  // namespace photond
