#include "renderer/voxels/voxel_intersector.h"

#include <algorithm>

#include "renderer/core/parallel.h"
#include "renderer/voxels/svo_shared.h"

namespace photond {

namespace {

constexpr float kVoxelDiagonal = 1.7321f;  // its length
constexpr float kReach = 8;  // lifts, voxel diagonals: how far along the ray its plane may be from the voxel
constexpr float kLeastDistance = 1e-3f;  // voxels
constexpr size_t kRaysATask = 256;

/// Barycentrics of the triangle's point that stands for p: its projection along the normal, cut to the triangle.
vec2 cut_barycentrics(const TriangleCorners& c, const vec3& p) {
    const vec3 e1 = c.p[1] - c.p[0], e2 = c.p[2] - c.p[0], w = p - c.p[0];
    const float d11 = glm::dot(e1, e1), d12 = glm::dot(e1, e2), d22 = glm::dot(e2, e2);
    const float w1 = glm::dot(w, e1), w2 = glm::dot(w, e2), determinant = d11 * d22 - d12 * d12;
    vec2 uv(0);
    if (determinant > 0)
        uv = vec2(d22 * w1 - d12 * w2, d11 * w2 - d12 * w1) / determinant;
    else if (d11 > 0)
        uv.x = w1 / d11;
    uv = glm::max(uv, vec2(0));
    return uv / std::max(1.0f, uv.x + uv.y);
}

/// Unit; 0 of a triangle that has none.
vec3 unit_normal(const TriangleCorners& c) {
    const vec3 n = glm::cross(c.p[1] - c.p[0], c.p[2] - c.p[0]);
    const float length = glm::length(n);
    return length > 0 ? n / length : vec3(0);
}

}  // namespace

VoxelIntersector::VoxelIntersector(const Scene& scene, const SparseVoxelOctree& tree) : scene_(scene), tree_(tree) {}

TriangleCorners VoxelIntersector::triangle(uint32_t number, uint32_t& instance, uint32_t& triangle) const {
    const std::span<const uint32_t> first = tree_.first_triangles();
    instance = static_cast<uint32_t>(std::upper_bound(first.begin(), first.end(), number) - first.begin() - 1);
    triangle = number - first[instance];
    return world_triangle(scene_, instance, triangle);
}

bool VoxelIntersector::plane_at(const vec3& position, vec3& normal, float& height) const {
    const float cell_m = tree_.constants().grid.cell_m;
    const auto plane_of = [&](uint32_t number, vec3& n) {
        uint32_t instance, triangle_there;
        const TriangleCorners corners = triangle(number, instance, triangle_there);
        n = unit_normal(corners);
        return glm::dot(n, position - corners.p[0]);
    };
    const uint32_t own = tree_.view().surface_at(position);
    if (own == ~0u) return false;
    height = plane_of(own, normal);
    for (int i = 0; i < 6; ++i) {
        vec3 beside = position, n;
        beside[i / 2] += i % 2 ? cell_m : -cell_m;
        const uint32_t number = tree_.view().surface_at(beside);
        if (number == ~0u || number == own) continue;
        const float distance = plane_of(number, n);
        if (!(std::fabs(distance) <= SVO_ON_PLANE * cell_m) || !(std::fabs(distance) < std::fabs(height))) continue;
        normal = n, height = distance;
    }
    return true;
}

vec3 VoxelIntersector::away_from_surface(const vec3& position, const vec3& along) const {
    vec3 n;
    float height;
    if (!plane_at(position, n, height)) return position;
    const float slope = glm::dot(n, along);
    const bool off = std::fabs(height) > SVO_ON_PLANE * tree_.constants().grid.cell_m;
    if (off && height * slope < 0) return position;
    return svo_lift(tree_.view(), position, slope < 0 ? -n : n);
}

Hit VoxelIntersector::closest_hit(const Ray& ray) const {
    const float length = glm::length(ray.direction), cell_m = tree_.constants().grid.cell_m;
    if (!(ray.t_max > 0) || !(length > 0)) return {};
    const vec3 along = ray.direction / length;
    const vec3 from = away_from_surface(ray.origin, along);
    const float skipped = std::max(glm::dot(from - ray.origin, along), 0.0f), reach = ray.t_max * length;
    VoxelHit voxel;
    if (!(skipped < reach) || !svo_first_voxel(tree_.view(), {from, along, reach - skipped}, voxel)) return {};

    Hit hit;
    const TriangleCorners corners = triangle(voxel.surface, hit.instance, hit.triangle);
    const vec3 n = unit_normal(corners);
    // The voxel is that of the lifted ray, the point that of the ray itself, which meets the plane elsewhere.
    const float enter = skipped + voxel.t, margin = kReach * glm::length(from - ray.origin);
    const float nearest = std::max(enter - margin, kLeastDistance * cell_m);
    const float farthest = std::max(enter + margin + kReach * kVoxelDiagonal * cell_m, nearest);
    const float slope = glm::dot(n, along), to_plane = glm::dot(n, corners.p[0] - ray.origin) / slope;
    const float distance = slope != 0 ? std::clamp(to_plane, nearest, farthest) : std::max(enter, nearest);
    hit.t = distance / length;
    if (!(hit.t > 0) || !(hit.t < ray.t_max)) return {};
    const vec2 uv = cut_barycentrics(corners, ray.origin + distance * along);
    hit.u = uv.x, hit.v = uv.y;
    return hit;
}

bool VoxelIntersector::occluded(const Ray& ray) const {
    const float length = glm::length(ray.direction);
    if (!(ray.t_max > 0) || !(length > 0)) return false;
    const vec3 along = ray.direction / length;
    const vec3 from = away_from_surface(ray.origin, along);
    VoxelHit voxel;
    if (!std::isfinite(ray.t_max)) return svo_first_voxel(tree_.view(), {from, along}, voxel);
    const vec3 to = away_from_surface(ray.origin + ray.t_max * ray.direction, -along);
    const float left = glm::length(to - from);
    if (!(glm::dot(to - from, along) > 0)) return false;  // nearer to each other than they were moved
    return svo_first_voxel(tree_.view(), {from, (to - from) / left, left}, voxel);
}

void VoxelIntersector::closest_hits(std::span<const Ray> rays, std::span<Hit> hits, Coherence) const {
    parallel_for(rays.size(), kRaysATask, [&](size_t i) { hits[i] = closest_hit(rays[i]); });
}

void VoxelIntersector::occluded(std::span<const Ray> rays, std::span<uint8_t> occluded_rays, Coherence) const {
    parallel_for(rays.size(), kRaysATask, [&](size_t i) { occluded_rays[i] = occluded(rays[i]); });
}

}  // namespace photond
