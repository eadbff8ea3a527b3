#pragma once
// What a method is given: the scene with its structures, what is looked at and how, and what its memory depends on.

#include <optional>

#include "renderer/core/memory_budget.h"
#include "renderer/film/film.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/intersector.h"
#include "renderer/scene/needs.h"

namespace photond {

class KeptVoxels;
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
    const Intersector* host_intersector = nullptr;   // on a GPU: answered by the cores, for who traces_on_host()
    KeptVoxels* kept_voxels = nullptr;  // of the scene's frame before (voxels/kept_voxels.h); null: nothing is kept
};

/// Photons that a scene stores for each light path started, on paths of any length.
struct PhotonYield {
    struct OfMap {
        double guided = 0;  // by projection maps, where they help
        double unguided = 0;

        double by(bool projection_maps) const { return projection_maps ? guided : unguided; }
    };
    OfMap global, caustic;
};

/// Of scenes in which nobody has measured it: the global map of a closed room with reflectances about a half (as in the
/// Cornell box), and the caustic map when specular surfaces fill a tenth.
inline constexpr PhotonYield kExpectedPhotonYield{.global = {0.905, 0.905}, .caustic = {0.1, 0.1}};

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

}  // namespace photond
