#include "renderer/many_lights/camera_importance.h"

#include "renderer/core/rng.h"
#include "renderer/many_lights/vpl.h"
#include "renderer/scene/scene.h"
#include "renderer/transport/bsdf.h"
#include "renderer/transport/surface.h"
#include "renderer/voxels/sparse_voxel_octree.h"

namespace photond {

CameraImportance::CameraImportance(const GBuffer& buffer, const SparseVoxelOctree* tree, float clamp_sq_m2,
                                   uint64_t seed, uint32_t pass)
    : points_(kPoints), tree_(tree), clamp_sq_m2_(clamp_sq_m2) {
    RandomStream random(seed, RandomDomain::Splats, pass, CAMERA_IMPORTANCE_STREAM);
    const std::span<const gpu::GBufferPoint> all = buffer.points();
    for (Point& mine : points_) {
        const gpu::GBufferPoint& point = all[size_t{random.next_bits()} % all.size()];
        if (point.kind == 0) continue;
        const bool general = (point.kind & GBUFFER_GENERAL) != 0;
        const float weight = max_component(point.weight) * (general ? kInvPi : 1.0f);
        mine = {point.position, point.normal, point.geometric_normal, weight};
    }
}

CameraImportance::CameraImportance(const Scene& scene, const Intersector& intersector, const View& view,
                                   float clamp_sq_m2, uint64_t seed)
    : points_(kPoints), clamp_sq_m2_(clamp_sq_m2) {
    RandomStream random(seed, RandomDomain::Splats, 0, CAMERA_IMPORTANCE_STREAM);
    const CameraRays camera_rays(view.camera, view.film_size);
    const vec2 size(view.film_size.width, view.film_size.height);
    std::vector<Ray> rays;
    for (uint32_t i = 0; i < kPoints; ++i) {
        const vec2 film = random.next_2d() * size;
        rays.push_back(camera_rays(film, random.next_2d()));
    }
    std::vector<Hit> hits(kPoints);
    intersector.closest_hits(rays, hits, Coherence::Incoherent);
    for (uint32_t i = 0; i < kPoints; ++i) {
        if (!hits[i].valid()) continue;
        const ShadingPoint at = make_shading_point(scene, hits[i], rays[i].direction);
        points_[i] = {at.position, at.shading.normal, at.geometric_normal,
                      max_component(make_bsdf(scene, at).albedo()) * kInvPi};
    }
}

float CameraImportance::unshadowed(const Point& point, const ReflectedPhoton& photon) const {
    const vec3 d = point.position - photon.position;
    const float d_sq = glm::dot(d, d);
    if (!(d_sq > 0)) return 0;
    const vec3 w = d / std::sqrt(d_sq);
    const float cos_o = glm::dot(photon.normal, w);
    const float cos_x = point.normal == vec3(0) ? 1.0f : -glm::dot(point.normal, w);
    if (!(cos_o > 0 && cos_x > 0)) return 0;
    return point.weight * cos_o * cos_x * clamped_falloff(d_sq, clamp_sq_m2_);
}

vec3 CameraImportance::lit_side(const Point& point, const ReflectedPhoton& photon) {
    return glm::dot(point.geometric_normal, photon.position - point.position) > 0 ? point.geometric_normal
                                                                                  : -point.geometric_normal;
}

float CameraImportance::operator()(const ReflectedPhoton& photon) const {
    float sum = 0;
    for (const Point& point : points_) {
        const float light = unshadowed(point, photon);
        if (!(light > 0)) continue;
        if (tree_ &&
            svo_occluded(tree_->view(), point.position, lit_side(point, photon), photon.position, photon.normal))
            continue;
        sum += light;
    }
    return sum;
}

uint64_t CameraImportance::brought(const Intersector& intersector, std::span<const ReflectedPhoton> photons,
                                   std::span<const uint32_t> elements, std::span<PhotonWorth> worth) const {
    struct Asked {
        uint32_t photon;
        float light;
    };
    std::vector<Ray> rays;
    std::vector<Asked> asked;
    for (uint32_t i = 0; i < photons.size(); ++i) {
        const ReflectedPhoton& photon = photons[i];
        const float flux_w = max_component(photon.power_w);
        const uint32_t first = hash32(elements[i]);
        worth[i] = {};
        for (uint32_t k = 0; k < CAMERA_IMPORTANCE_ASKED; ++k) {
            const Point& point = points_[(first + k) % kPoints];
            const float light = unshadowed(point, photon) * flux_w;
            if (!(light > 0)) continue;
            const vec3 from = offset_ray_origin(point.position, lit_side(point, photon));
            rays.push_back({from, offset_ray_origin(photon.position, photon.normal) - from, kConnectionEnd});
            asked.push_back({i, light});
            worth[i].unshadowed += light;
        }
    }
    std::vector<uint8_t> occluded(rays.size());
    intersector.occluded(rays, occluded, Coherence::Incoherent);
    for (size_t k = 0; k < asked.size(); ++k)
        if (!occluded[k]) worth[asked[k].photon].seen += asked[k].light;
    return rays.size();
}

}  // namespace photond
