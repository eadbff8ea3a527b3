#pragma once
// The method interface: begin, passes, resolve. A method knows neither time limits nor references nor where files go;
// the job runner owns the loop (server/worker/job_runner.h).

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/param_info.h"
#include "renderer/core/cancel.h"
#include "renderer/core/memory_budget.h"
#include "renderer/core/stats.h"
#include "renderer/film/film.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/intersector.h"
#include "renderer/scene/needs.h"

namespace photond {

struct Scene;
namespace gpu {
class DeviceScene;
}

enum class PixelFilter : uint8_t { Box, Gaussian, BlackmanHarris };

/// What is looked at and how.
struct View {
    Camera camera;
    Size2 film_size;
    PixelFilter filter = PixelFilter::Box;
    LayerSet layers;
};

/// The scene and the structures all methods share; borrowed until the method is gone. A method has what its device's
/// kind asks for: rays on the CPU, or the scene on the GPU.
struct RenderContext {
    const Scene& scene;
    const Intersector* intersector;  // on a GPU: answered by it (backends/gpu/device_intersector.h), for few rays
    View view;
    uint64_t seed = 1;
    MemoryBudget& budget;                            // of the host
    const gpu::DeviceScene* device_scene = nullptr;  // null on the CPU
};

/// Photons that a scene stores for each light path started, on paths of any length.
struct PhotonYield {
    double global = 0;
    double caustic = 0;           // by projection maps, where they help
    double caustic_unguided = 0;  // without
};

/// What a method's own memory depends on, as far as it is known before anything is loaded.
struct Workload {
    Size2 film_size;
    LayerSet layers;
    unsigned threads = 1;
    uint64_t lights = 0;       // triangles that emit, and punctual lights
    Size2 environment_size{};  // 0 x 0: none
    uint64_t triangles = 0;
    Needs needs;                              // all false while nothing is known of the scene
    std::optional<PhotonYield> photon_yield;  // where it has been measured
};

/// A file that a method can leave beside the image. `name` is one that its row in the registry declares.
struct MethodArtefact {
    std::string name;
    std::string media_type;
    std::function<void(const std::filesystem::path& path)> write;  // whole or not at all (core/atomic_file.h)
};

class Method {
public:
    virtual ~Method() = default;

    /// Builds what the passes need. Called once. Throws ErrorCode::OutOfMemory before allocating past the budget.
    virtual void begin(const RenderContext& context, Stats& stats) = 0;
    /// Renders one pass, a pure function of (scene, view, parameters, seed, pass), whatever the number of threads. When
    /// `cancel` is seen the pass is left unfinished and nothing of it may reach the film.
    virtual void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) = 0;
    /// Said between run_pass() and resolve(): that pass is wanted next. A method whose work another device does begins
    /// it now, so that the device works while this pass is folded into the film, measured and written.
    virtual void expect_pass(uint32_t /*pass*/) {}
    /// Waits for what expect_pass() began: said on the job's clock before something that is off it, so that no work is
    /// done for nothing.
    virtual void settle() {}
    /// Folds the pass just finished into the film.
    virtual void resolve(Film& film) = 0;
    /// What the passes leave for whoever wants to look inside. Asked once, after the last pass, when at least one was
    /// resolved; borrows from the method.
    virtual std::vector<MethodArtefact> artefacts() const { return {}; }
};

}  // namespace photond
