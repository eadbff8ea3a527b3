#pragma once
// What virtual point lights see: a small depth map each, of the half space before its surface. GLSL twin:
// vpl_shadow_maps.glsl.
//
// A map is a square of r x r texels, the octahedral map of the hemisphere about the light's geometric normal
// [Cigolle et al. 2014, A Survey of Efficient Representations for Independent Unit Vectors, JCGT 3(2): hemi-oct]. A
// texel holds one distance: as far as light goes there.
//
// Bias. The ray through a texel's centre meets a plane at distance m. What the texel holds is the greatest distance of
// that plane from the light over the texel's four corners: m times n.w_centre / n.w_corner, so the slope counts as it
// is, and no plane that fills a texel shadows itself, however it leans, up to kMostStretch; and kTolerance of a texel's
// width at that distance beyond that, for surfaces that bend. Lit falsely: what lies less than that behind an occluder,
// and what an occluder's edge hides in the texels it goes through, as far as their centres miss it. Dark falsely: the
// rest of those texels, and planes seen at a slope that changes their distance by more than kMostStretch in a texel.

#include <algorithm>
#include <span>
#include <vector>

#include "renderer/core/stats.h"
#include "renderer/many_lights/vpl.h"
#include "renderer/scene/intersector.h"

namespace photond {

namespace vpl_map {

inline constexpr uint32_t kLeastResolution = 4, kMostResolution = 128;
inline constexpr float kMostStretch = 4;
inline constexpr float kTolerance = 0.25f;

/// The unit direction, local to the light's frame, of a place in the map, [0, 1]^2.
inline vec3 direction(const vec2& place) {
    const vec2 e = 2.0f * place - 1.0f;
    const float x = 0.5f * (e.x + e.y), y = 0.5f * (e.x - e.y);
    return glm::normalize(vec3(x, y, 1 - std::fabs(x) - std::fabs(y)));
}

/// Its inverse, for local vectors of any length but 0 with z >= 0.
inline vec2 place(const vec3& local) {
    const vec2 p = vec2(local.x, local.y) / (std::fabs(local.x) + std::fabs(local.y) + local.z);
    return 0.5f * vec2(p.x + p.y, p.x - p.y) + 0.5f;
}

/// Row after row.
inline uint32_t texel(const vec2& place, uint32_t resolution) {
    const float side = static_cast<float>(resolution);
    const auto column = static_cast<uint32_t>(std::clamp(place.x * side, 0.0f, side - 1));
    const auto row = static_cast<uint32_t>(std::clamp(place.y * side, 0.0f, side - 1));
    return row * resolution + column;
}

/// A texel's centre.
inline vec3 texel_direction(uint32_t texel, uint32_t resolution) {
    const uint32_t row = texel / resolution, column = texel % resolution;
    const vec2 at(static_cast<float>(column), static_cast<float>(row));
    return direction((at + 0.5f) / static_cast<float>(resolution));
}

/// What a texel holds whose centre's ray meets a surface of that local normal, of either sign, at `distance_m`.
float reach_m(uint32_t texel, uint32_t resolution, float distance_m, const vec3& local_normal);

}  // namespace vpl_map

/// The maps of one set of lights, traced. Masked and blended surfaces count as in Intersector.
class VplShadowMaps {
public:
    /// `resolution` texels along each side, kLeastResolution to kMostResolution.
    explicit VplShadowMaps(uint32_t resolution);

    /// Replaces the maps: one ray a texel, from the light's own surface. Stage `shadow_maps`; adds to shadow_rays.
    void build(std::span<const gpu::Vpl> vpls, const Scene& scene, const Intersector& intersector, Stats& stats);

    /// Whether light `light` does not reach the point [m]; so too for points behind its surface. Thread-safe.
    bool occluded(size_t light, const vec3& point) const {
        const Light& at = lights_[light];
        const vec3 local = at.axes.to_local(point - at.position);
        if (!(local.z > 0)) return true;
        const uint32_t texel = vpl_map::texel(vpl_map::place(local), resolution_);
        return glm::dot(local, local) > sqr(reach_m_[light * resolution_ * resolution_ + texel]);
    }

    uint32_t resolution() const { return resolution_; }
    /// By light, row and column; infinite where nothing stands.
    std::span<const float> reach_m() const { return reach_m_; }
    uint64_t bytes() const { return lights_.capacity() * sizeof(Light) + reach_m_.capacity() * sizeof(float); }
    static uint64_t bytes_for(uint64_t lights, uint32_t resolution) {
        return lights * (sizeof(Light) + uint64_t{resolution} * resolution * sizeof(float));
    }

private:
    struct Light {
        vec3 position;
        Frame axes;
    };
    uint32_t resolution_;
    std::vector<Light> lights_;
    std::vector<float> reach_m_;
};

}  // namespace photond
