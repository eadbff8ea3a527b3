#include "renderer/photons/emission_grid.h"

#include <algorithm>

#include "renderer/scene/scene.h"

namespace photond {

EmissionResolution emission_resolution(const Scene& scene, uint32_t light, int levels) {
    const size_t triangles = scene.triangle_lights.size(), punctual = scene.punctual_lights.size();
    int direction_levels = levels;
    if (light < triangles) {
        const float size = std::sqrt(scene.triangle_lights[light].area_m2) / scene.bounds.radius();
        const float balanced = 0.5f * (static_cast<float>(levels) - std::log2(size));
        direction_levels = static_cast<int>(std::lround(std::clamp(balanced, 0.0f, static_cast<float>(levels))));
    } else if (light >= triangles + punctual) {
        direction_levels = (levels + 1) / 2;
    } else if (scene.punctual_lights[light - triangles].kind == PunctualLight::Kind::Directional) {
        direction_levels = 0;
    }
    return {1u << (levels - direction_levels), 1u << direction_levels};
}

}  // namespace photond
