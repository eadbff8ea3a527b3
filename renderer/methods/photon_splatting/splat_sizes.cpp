#include "renderer/methods/photon_splatting/splat_sizes.h"

#include <algorithm>
#include <cmath>

#include "renderer/scene/scene.h"

namespace photond {

namespace {

constexpr float kMostFactor = 3;

/// Sums of each cell and its neighbours along one axis, `stride` apart.
void box_filter(std::vector<float>& values, const uvec3& cells, int axis) {
    const size_t stride = axis == 0 ? 1 : axis == 1 ? cells.x : size_t{cells.x} * cells.y;
    const std::vector<float> before = values;
    for (size_t i = 0; i < values.size(); ++i) {
        const size_t at = i / stride % cells[axis];
        if (at > 0) values[i] += before[i - stride];
        if (at + 1 < cells[axis]) values[i] += before[i + stride];
    }
}

}  // namespace

SplatSizes::SplatSizes(float radius_m, const Bounds3& bounds, const TracedReflections& pilot,
                       const Intersector& intersector, Counts& counts)
    : radius_m_(radius_m), low_(bounds.min) {
    const vec3 extent = bounds.diagonal();
    const float longest = std::max({extent.x, extent.y, extent.z});
    if (!(longest > 0) || pilot.photons.empty()) return;
    cell_m_ = longest / static_cast<float>(kCells);
    cells_ = uvec3(extent / cell_m_) + 1u;

    std::vector<Ray> rays;
    for (const ReflectedPhoton& photon : pilot.photons) {
        const float side = glm::dot(photon.normal, photon.direction) < 0 ? -1.0f : 1.0f;
        rays.push_back({offset_ray_origin(photon.position, side * photon.normal), photon.direction, kInfinity});
    }
    std::vector<Hit> hits(rays.size());
    intersector.closest_hits(rays, hits, Coherence::Incoherent);
    counts.photon_rays += rays.size();

    std::vector<float> lengths(size_t{cells_.x} * cells_.y * cells_.z, 0.0f), volumes(lengths.size(), 1.0f);
    const float step_m = 0.5f * cell_m_;
    double total = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
        const float end_m = std::min(hits[i].t, 2 * longest);  // the scene is no wider
        const auto steps = static_cast<uint32_t>(std::lround(end_m / step_m));
        for (uint32_t step = 0; step < steps; ++step) {
            const vec3 p = rays[i].origin + (static_cast<float>(step) + 0.5f) * step_m * rays[i].direction;
            if (glm::any(glm::lessThan(p, bounds.min)) || glm::any(glm::greaterThan(p, bounds.max))) break;
            lengths[index(cell(p))] += 1;
            total += 1;
        }
    }
    if (!(total > 0)) return;
    const dvec3 sides = glm::max(dvec3(extent) / double{cell_m_}, dvec3(1));  // in cells; a flat scene fills one
    const auto average = static_cast<float>(total / (sides.x * sides.y * sides.z));
    for (int axis = 0; axis < 3; ++axis) {
        box_filter(lengths, cells_, axis);
        box_filter(volumes, cells_, axis);
    }
    factors_.resize(lengths.size());
    for (size_t i = 0; i < lengths.size(); ++i) {
        const float density = lengths[i] / volumes[i];
        factors_[i] = std::clamp(std::sqrt(average / std::max(density, 1e-3f * average)), 1 / kMostFactor, kMostFactor);
    }
}

uvec3 SplatSizes::cell(const vec3& p) const {
    const vec3 place = glm::clamp((p - low_) / cell_m_, vec3(0), vec3(cells_) - 1.0f);
    return uvec3(place);
}

float SplatSizes::radius_m(const vec3& p, const vec3& n) const {
    if (factors_.empty()) return radius_m_;
    return radius_m_ * factors_[index(cell(p + cell_m_ * n))];  // in front of the surface, not within it
}

}  // namespace photond
