#pragma once
// What all tiles and passes of one path-traced render share.

#include <vector>

#include "renderer/methods/eye_scene.h"
#include "renderer/methods/path_tracing/path_tracing.h"
#include "renderer/transport/lambert_lanes.h"

namespace photond {

struct PathTracingScene : EyeScene {
    /// How the hits of an instance are shaded.
    struct Shading {
        bool lambert;  // by lambert_shading.cpp
        bool varies;   // the reflectance, by texture or vertex colour
        bool emits;
    };

    PathTracingScene(const RenderContext& context, const PathTracingParams& params)
        : EyeScene(context, params.sampler, params.max_scatterings()), roulette_start(params.roulette_start) {
        for (const Instance& instance : scene.instances) {
            const Mesh& mesh = scene.meshes[instance.mesh];
            const Material& m = scene.materials[mesh.material];
            shading.push_back(
                {.lambert = is_plain_lambert(m), .varies = base_color_varies(scene, mesh), .emits = m.emissive()});
        }
    }

    const uint32_t roulette_start;
    std::vector<Shading> shading;  // by instance
};

}  // namespace photond
