#include "renderer/many_lights/camera_importance.h"

#include "renderer/core/rng.h"
#include "renderer/many_lights/vpl.h"
#include "renderer/voxels/sparse_voxel_octree.h"

namespace photond {

namespace {

constexpr uint64_t kPointStream = 1;  // of RandomDomain::Splats in a pass

}  // namespace

CameraImportance::CameraImportance(const GBuffer& buffer, const SparseVoxelOctree* tree, float clamp_sq_m2,
                                   uint64_t seed, uint32_t pass)
    : tree_(tree), clamp_sq_m2_(clamp_sq_m2) {
    RandomStream random(seed, RandomDomain::Splats, pass, kPointStream);
    const std::span<const gpu::GBufferPoint> all = buffer.points();
    for (uint32_t i = 0; i < kPoints; ++i) {
        const gpu::GBufferPoint& point = all[size_t{random.next_bits()} % all.size()];
        if (point.kind == 0) continue;
        const bool general = (point.kind & GBUFFER_GENERAL) != 0;
        const float weight = max_component(point.weight) * (general ? kInvPi : 1.0f);
        points_.push_back({point.position, point.normal, point.geometric_normal, weight});
    }
}

float CameraImportance::operator()(const ReflectedPhoton& photon) const {
    float sum = 0;
    for (const Point& point : points_) {
        const vec3 d = point.position - photon.position;
        const float d_sq = glm::dot(d, d);
        if (!(d_sq > 0)) continue;
        const vec3 w = d / std::sqrt(d_sq);
        const float cos_o = glm::dot(photon.normal, w);
        const float cos_x = point.normal == vec3(0) ? 1.0f : -glm::dot(point.normal, w);
        if (!(cos_o > 0 && cos_x > 0)) continue;
        const vec3 side = glm::dot(point.geometric_normal, w) < 0 ? point.geometric_normal : -point.geometric_normal;
        if (tree_ && svo_occluded(tree_->view(), point.position, side, photon.position, photon.normal)) continue;
        sum += point.weight * cos_o * cos_x * clamped_falloff(d_sq, clamp_sq_m2_);
    }
    return sum;
}

}  // namespace photond
