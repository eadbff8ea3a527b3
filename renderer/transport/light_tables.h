#pragma once
// The lights of a scene as arrays that shaders read: LightSampler and EmissionSampler for the device. The samplers
// themselves make them, so that device and host draw by the same numbers.

#include <span>
#include <vector>

#include "renderer/core/rgb.h"
#include "renderer/transport/light_tables_shared.h"

namespace photond {

struct Scene;

/// What scene_bindings.h calls EMITTERS to ENVIRONMENT, and LIGHT_CONSTANTS. Arrays a scene has no use for are empty.
struct LightTables {
    gpu::LightConstants constants{};
    std::vector<gpu::EmitterRecord>
        emitters;  // of the light tree, then Scene::triangle_lights where parallelograms hide them
    std::vector<gpu::LightNodeRecord> nodes;  // of the light tree; [0] is the root
    std::vector<uint32_t> words;
    std::vector<gpu::PunctualLightRecord> punctual_lights;
    std::vector<float> floats;
    std::span<const Rgb> environment;  // radiance, the map's texels; borrowed from the scene
};

/// Of a finished scene. Throws ErrorCode::Unsupported past the number of lights that a node can point to.
LightTables make_light_tables(const Scene& scene);

}  // namespace photond
