#pragma once
// What all tiles and passes of one render that follows paths from the eye share: prepared once by begin(), read by all
// threads.

#include <vector>

#include "renderer/eye/pixel_filter.h"
#include "renderer/frame/render_context.h"
#include "renderer/transport/lambert_lanes.h"
#include "renderer/transport/light_sampling.h"
#include "renderer/transport/medium_stack.h"
#include "renderer/transport/sobol.h"

namespace photond {

struct EyeScene {
    /// How the hits of an instance are shaded.
    struct Shading {
        bool lambert;  // in lanes: LambertGroup knows it
        bool varies;   // the reflectance, by texture or vertex colour
        bool emits;
    };

    EyeScene(const RenderContext& context, SamplerKind sampler_kind, uint32_t most_scatterings)
        : scene(context.scene),
          intersector(*context.intersector),
          lights(context.scene),
          absorption(context.scene),
          view(context.view),
          camera_rays(context.view.camera, context.view.film_size),
          filter(context.view.filter),
          seed(context.seed),
          sampler(sampler_kind),
          max_scatterings(most_scatterings) {
        shading.reserve(scene.instances.size());
        for (const Instance& instance : scene.instances) {
            const Mesh& mesh = scene.meshes[instance.mesh];
            const Material& m = scene.materials[mesh.material];
            shading.push_back(
                {.lambert = is_plain_lambert(m), .varies = base_color_varies(scene, mesh), .emits = m.emissive()});
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
    std::vector<Shading> shading;  // by instance
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
