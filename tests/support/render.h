#pragma once
// Renders with path tracing from within a test.

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/methods/path_tracing/path_tracing.h"

namespace photond::test {

struct RenderSettings {
    Size2 size{32, 32};
    uint32_t passes = 1;
    uint32_t first_pass = 0;
    uint64_t seed = 1;
    PathTracingParams params;
    LayerSet layers;
    PixelFilter filter = PixelFilter::Box;
};

/// The film of those passes, seen by the scene's first camera.
inline Film render(const Scene& scene, const RenderSettings& settings) {
    MemoryBudget budget;
    Stats stats;
    const std::unique_ptr<Intersector> intersector = make_embree_intersector(scene, budget, stats);
    PathTracing method(settings.params);
    method.begin({scene, *intersector, View{find_camera(scene, ""), settings.size, settings.filter, settings.layers},
                  settings.seed, budget},
                 stats);
    Film film(settings.size, settings.layers);
    for (uint32_t i = 0; i < settings.passes; ++i) {
        method.run_pass(settings.first_pass + i, stats, CancelToken{});
        method.resolve(film);
    }
    return film;
}

/// Mean over pixels and channels.
inline double mean_of(const std::vector<float>& values) {
    double sum = 0;
    for (const float value : values) sum += value;
    return sum / double(values.size());
}

}  // namespace photond::test
