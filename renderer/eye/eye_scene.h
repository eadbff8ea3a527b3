#pragma once
// What all tiles and passes of one render that follows paths from the eye share: prepared once by begin(), read by all
// threads.

#include <vector>

#include "renderer/eye/eye_shared.h"
#include "renderer/eye/pixel_filter.h"
#include "renderer/frame/render_context.h"
#include "renderer/transport/environment_sampling.h"
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

    /// `environment`: how light samples are drawn from it (environment_sampling.h).
    EyeScene(const RenderContext& context, SamplerKind sampler_kind, uint32_t most_scatterings,
             EnvironmentDensity environment = EnvironmentDensity::Radiance)
        : scene(context.scene),
          intersector(*context.intersector),
          lights(context.scene, environment),
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

/// Two-dimensional sets of random numbers (eye_shared.h).
enum class CameraSet : uint32_t { Film = SET_FILM, Lens = SET_LENS };
enum class VertexSet : uint32_t {
    LightPoint = SET_LIGHT_POINT,
    LightChoiceAndRoulette = SET_LIGHT_CHOICE_AND_ROULETTE,
    Direction = SET_DIRECTION,
    Lobe = SET_LOBE,
};
constexpr uint32_t sample_set(CameraSet set) { return static_cast<uint32_t>(set); }
constexpr uint32_t sample_set(uint32_t vertex, VertexSet set) {
    constexpr uint32_t kFirstVertices[] = {SETS_OF_FIRST_VERTICES};
    const auto kind = static_cast<uint32_t>(set);
    return vertex < 4 ? kFirstVertices[4 * vertex + kind] : 2 + 4 * vertex + kind;
}

}  // namespace photond
