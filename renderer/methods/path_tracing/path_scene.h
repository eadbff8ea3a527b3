#pragma once
// What all tiles and passes of one render share: prepared once by begin(), read by all threads.

#include <array>
#include <vector>

#include "renderer/methods/method.h"
#include "renderer/methods/path_tracing/path_tracing.h"
#include "renderer/methods/pixel_filter.h"
#include "renderer/transport/light_sampling.h"
#include "renderer/transport/medium_stack.h"

namespace photond {

struct PathTracingScene {
    /// How the hits of an instance are shaded.
    struct Shading {
        bool lambert;  // by lambert_shading.cpp
        bool varies;   // the reflectance, by texture or vertex colour
        bool emits;
    };

    PathTracingScene(const RenderContext& context, const PathTracingParams& params)
        : scene(context.scene),
          intersector(context.intersector),
          lights(context.scene),
          absorption(context.scene),
          view(context.view),
          camera_rays(context.view.camera, context.view.film_size),
          filter(context.view.filter),
          seed(context.seed),
          sampler(params.sampler),
          max_scatterings(params.max_scatterings()),
          roulette_start(params.roulette_start) {
        for (const Instance& instance : scene.instances) {
            const Mesh& mesh = scene.meshes[instance.mesh];
            const Material& m = scene.materials[mesh.material];
            shading.push_back({.lambert = !m.unlit && m.metallic == 0 && m.specular == 0 && m.transmission == 0 &&
                                          !m.normal_texture.used(),
                               .varies = m.base_color_texture.used() || !mesh.colors.empty(),
                               .emits = m.emissive()});
        }
    }

    const Scene& scene;
    const Intersector& intersector;
    const LightSampler lights;
    const Absorption absorption;
    const View view;
    const CameraRays camera_rays;
    const PixelFilterSampler filter;
    const uint64_t seed;
    const SamplerKind sampler;
    const uint32_t max_scatterings;
    const uint32_t roulette_start;
    std::vector<Shading> shading;  // by instance
};

/// A rectangle of pixels, traced as one batch by one thread.
struct Tile {
    uint32_t x0, y0, x1, y1;  // half open
    size_t pixels() const { return size_t{x1 - x0} * (y1 - y0); }
};

/// Two-dimensional sets of random numbers: two for the camera, then four for each vertex, the camera's included. The
/// first ones, which are distributed best (sobol.h), go where most of the variance comes from: the first bounce's
/// direction and light, roulette, then the rest of the first vertices.
enum class CameraSet : uint32_t { Film, Lens };
enum class VertexSet : uint32_t { LightPoint, LightChoiceAndRoulette, Direction, Lobe };
constexpr uint32_t sample_set(CameraSet set) { return set == CameraSet::Film ? 4 : 14; }
constexpr uint32_t sample_set(uint32_t vertex, VertexSet set) {
    constexpr uint32_t kFirstVertices[4][4] = {{5, 2, 0, 8}, {1, 7, 3, 12}, {6, 11, 9, 15}, {10, 16, 13, 17}};
    const auto kind = static_cast<uint32_t>(set);
    return vertex < 4 ? kFirstVertices[vertex][kind] : 2 + 4 * vertex + kind;
}

}  // namespace photond
