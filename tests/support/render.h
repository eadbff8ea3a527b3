#pragma once
// Renders with any method from within a test.

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/core/thread_local.h"
#include "renderer/frame/method.h"
#include "renderer/scene/scene.h"

namespace photond::test {

/// How a test renders with the method M. `RenderSettingsOf<PhotonMapping> settings; settings.params.photons = 1000;`
template <class M>
struct RenderSettingsOf {
    Size2 size{32, 32};
    uint32_t passes = 1;
    uint32_t first_pass = 0;
    uint64_t seed = 1;
    typename M::Params params;
    LayerSet layers;
    PixelFilter filter = PixelFilter::Box;
};

/// What the scene's first camera sees.
template <class M>
View view_of(const Scene& scene, const RenderSettingsOf<M>& settings) {
    return {find_camera(scene, ""), settings.size, settings.filter, settings.layers};
}

/// What a method is told of the scene and the film to estimate its memory by.
template <class M>
Workload workload_of(const Scene& scene, const RenderSettingsOf<M>& settings) {
    Workload workload{.film_size = settings.size, .layers = settings.layers, .threads = unsigned(most_threads())};
    workload.lights = scene.triangle_lights.size() + scene.punctual_lights.size();
    if (scene.environment) workload.environment_size = scene.environment->map.size;
    workload.triangles = scene.triangle_count;
    workload.needs = scene.needs;
    return workload;
}

/// Renders those passes in a context and calls after_pass(method, pass) after each.
template <class M, class AfterPass>
void run_passes_in(const RenderContext& context, const RenderSettingsOf<M>& settings, const AfterPass& after_pass,
                   Stats& stats) {
    M method(settings.params);
    method.begin(context, stats);
    for (uint32_t i = 0; i < settings.passes; ++i) {
        method.run_pass(settings.first_pass + i, stats, CancelToken{});
        after_pass(method, settings.first_pass + i);
    }
}

/// Renders those passes, seen by the scene's first camera, and calls after_pass(method, pass) after each, for it to
/// resolve() the pass into films. Counts, stages and skipped parts go to `stats`, what the method recorded to `budget`,
/// when they are asked for.
template <class M, class AfterPass>
void run_passes(const Scene& scene, const RenderSettingsOf<M>& settings, const AfterPass& after_pass,
                Stats* stats = nullptr, MemoryBudget* budget = nullptr) {
    MemoryBudget own_budget, ray_structures;
    Stats own_stats;
    Stats& counted = stats ? *stats : own_stats;
    const std::unique_ptr<Intersector> intersector = make_embree_intersector(scene, ray_structures, counted);
    const RenderContext context{scene, intersector.get(), view_of(scene, settings), settings.seed,
                                budget ? *budget : own_budget};
    run_passes_in(context, settings, after_pass, counted);
}

/// The film of those passes.
template <class M>
Film render(const Scene& scene, const RenderSettingsOf<M>& settings, Stats* stats = nullptr,
            MemoryBudget* budget = nullptr) {
    Film film(settings.size, settings.layers, settings.first_pass);
    run_passes(
        scene, settings, [&](M& method, uint32_t) { method.resolve(film); }, stats, budget);
    return film;
}

/// Mean over pixels and channels.
inline double mean_of(const std::vector<float>& values) {
    double sum = 0;
    for (const float value : values) sum += value;
    return sum / double(values.size());
}

}  // namespace photond::test
