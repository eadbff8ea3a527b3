#pragma once
// The method interface: begin, passes, resolve. A method knows neither time limits nor references nor files; the job
// runner owns the loop (server/worker/job_runner.h).

#include <memory>

#include "protocol/param_info.h"
#include "renderer/core/cancel.h"
#include "renderer/core/memory_budget.h"
#include "renderer/core/stats.h"
#include "renderer/film/film.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/intersector.h"
#include "renderer/scene/scene.h"

namespace photond {

enum class PixelFilter : uint8_t { Box, Gaussian, BlackmanHarris };

/// What is looked at and how.
struct View {
    Camera camera;
    Size2 film_size;
    PixelFilter filter = PixelFilter::Box;
    LayerSet layers;
};

/// The scene and the structures all methods share; borrowed until the method is gone.
struct RenderContext {
    const Scene& scene;
    const Intersector& intersector;
    View view;
    uint64_t seed = 1;
    MemoryBudget& budget;
};

/// What a method's own memory depends on, as far as it is known before anything is loaded.
struct Workload {
    Size2 film_size;
    LayerSet layers;
    unsigned threads = 1;
    uint64_t lights = 0;       // triangles that emit, and punctual lights
    Size2 environment_size{};  // 0 x 0: none
};

class Method {
public:
    virtual ~Method() = default;

    /// Builds what the passes need. Called once. Throws ErrorCode::OutOfMemory before allocating past the budget.
    virtual void begin(const RenderContext& context, Stats& stats) = 0;
    /// Renders one pass, a pure function of (scene, view, parameters, seed, pass), whatever the number of threads. When
    /// `cancel` is seen the pass is left unfinished and nothing of it may reach the film.
    virtual void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) = 0;
    /// Folds the pass just finished into the film.
    virtual void resolve(Film& film) = 0;
};

}  // namespace photond
