#include "renderer/many_lights/vpl_shadow_maps.h"

#include <cassert>

#include "renderer/core/parallel.h"
#include "renderer/transport/surface.h"

namespace photond {

float vpl_map::reach_m(uint32_t texel, uint32_t resolution, float distance_m, const vec3& local_normal) {
    const uint32_t row = texel / resolution, column = texel % resolution;
    const vec2 low(static_cast<float>(column), static_cast<float>(row));
    const auto side = static_cast<float>(resolution);
    const vec3 centre = direction((low + 0.5f) / side);
    const float cos_centre = glm::dot(local_normal, centre);
    float stretch = 1, most_cos = 0;
    for (uint32_t i = 0; i < 4; ++i) {
        const vec3 corner = direction((low + vec2(static_cast<float>(i & 1), static_cast<float>(i >> 1))) / side);
        const float ratio = glm::dot(local_normal, corner) / cos_centre;
        stretch = std::max(stretch, ratio > 1 / kMostStretch ? 1 / ratio : kMostStretch);
        most_cos = std::max(most_cos, 1 - glm::dot(corner, centre));
    }
    // Half a diagonal is an angle of sqrt(2 (1 - cos)), a width sqrt(2) times that.
    return distance_m * (stretch + kTolerance * 2 * std::sqrt(most_cos));
}

VplShadowMaps::VplShadowMaps(uint32_t resolution) : resolution_(resolution) {
    assert(resolution >= vpl_map::kLeastResolution && resolution <= vpl_map::kMostResolution);
}

void VplShadowMaps::build(std::span<const gpu::Vpl> vpls, const Scene& scene, const Intersector& intersector,
                          Stats& stats) {
    const StageTimer timer(stats, "shadow_maps");
    const size_t texels = size_t{resolution_} * resolution_;
    lights_.clear();
    lights_.reserve(vpls.size());
    for (const gpu::Vpl& vpl : vpls) lights_.push_back({vpl.position, Frame(vpl.normal)});
    reach_m_.resize(vpls.size() * texels);
    parallel_for(vpls.size(), 1, [&](size_t light) {
        const Frame& axes = lights_[light].axes;
        const vec3 origin = offset_ray_origin(lights_[light].position, axes.normal);
        std::vector<Ray> rays(texels);
        std::vector<Hit> hits(texels);
        for (uint32_t texel = 0; texel < texels; ++texel)
            rays[texel] = {origin, axes.to_world(vpl_map::texel_direction(texel, resolution_))};
        intersector.closest_hits(rays, hits, Coherence::Coherent);
        float* reach_m = &reach_m_[light * texels];
        for (uint32_t texel = 0; texel < texels; ++texel) {
            reach_m[texel] = kInfinity;
            if (!hits[texel].valid()) continue;
            const vec3 normal = make_plain_shading_point(scene, hits[texel], rays[texel].direction).geometric_normal;
            reach_m[texel] = vpl_map::reach_m(texel, resolution_, hits[texel].t, axes.to_local(normal));
        }
    });
    stats.counts.shadow_rays += vpls.size() * texels;
}

}  // namespace photond
