#include "renderer/backends/cpu/small_scene_intersector.h"

#include <algorithm>
#include <cassert>

#include "renderer/core/lanes.h"
#include "renderer/core/rgb.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace stdx = std::experimental;

namespace {

/// Whether no triangle is so small in the scene that the moments of lines, which are about the origin, have no digits
/// left for it: of rays that leave one of a thousandth, 5e-4 met it again, of a ten thousandth 6 %, of this share none.
bool is_even(const Scene& scene) {
    constexpr float kLeastShare = 1.0f / 128;  // of the farthest coordinate
    const float farthest =
        std::max(max_component(glm::abs(scene.bounds.min)), max_component(glm::abs(scene.bounds.max)));
    for (uint32_t i = 0; i < scene.instances.size(); ++i)
        for (uint32_t k = 0; k < scene.meshes[scene.instances[i].mesh].triangles.size(); ++k) {
            const TriangleCorners c = world_triangle(scene, i, k);
            const float longest =
                std::max({glm::distance(c.p[0], c.p[1]), glm::distance(c.p[1], c.p[2]), glm::distance(c.p[2], c.p[0])});
            if (longest < kLeastShare * farthest) return false;
        }
    return true;
}

}  // namespace

bool SmallSceneIntersector::suits(const Scene& scene) {
    return scene.triangle_count <= kMaxTriangles && !scene.needs.alpha && is_even(scene);
}

SmallSceneIntersector::SmallSceneIntersector(const Scene& scene) {
    triangles_.reserve(scene.triangle_count);
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
        for (uint32_t k = 0; k < mesh.triangles.size(); ++k) {
            const TriangleCorners c = world_triangle(scene, i, k);
            Triangle t;
            for (int corner = 0; corner < 3; ++corner)
                t.edges[corner] = line_between(c.p[(corner + 1) % 3], c.p[(corner + 2) % 3]);
            t.normal = glm::cross(c.p[1] - c.p[0], c.p[2] - c.p[0]);
            t.offset = glm::dot(t.normal, c.p[0]);
            t.instance = i;
            t.triangle = k;
            triangles_.push_back(t);
        }
    }
}

/// Two triangles that share an edge see it in opposite directions. It is computed in one and negated for the other, so
/// that a ray's side of it has exactly opposite signs for the two: no ray slips between them.
SmallSceneIntersector::Line SmallSceneIntersector::line_between(const vec3& a, const vec3& b) {
    const bool ordered = a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
    const vec3 &from = ordered ? a : b, &to = ordered ? b : a;
    const float sign = ordered ? 1.0f : -1.0f;
    return {sign * (to - from), sign * glm::cross(from, to)};
}

/// As many rays as the machine has lanes.
struct SmallSceneIntersector::RayLanes {
    Vec3Lanes origin, direction, moment;
    FloatLanes t_max;

    /// Rays past the end of the span repeat its last.
    explicit RayLanes(std::span<const Ray> rays) {
        const auto lanes = [&](auto&& member) {
            return rays.size() >= kLanes
                       ? FloatLanes([&](auto i) { return member(rays[i]); })
                       : FloatLanes([&](auto i) { return member(rays[std::min(size_t(i), rays.size() - 1)]); });
        };
        origin = {lanes([](const Ray& r) { return r.origin.x; }), lanes([](const Ray& r) { return r.origin.y; }),
                  lanes([](const Ray& r) { return r.origin.z; })};
        direction = {lanes([](const Ray& r) { return r.direction.x; }),
                     lanes([](const Ray& r) { return r.direction.y; }),
                     lanes([](const Ray& r) { return r.direction.z; })};
        t_max = lanes([](const Ray& r) { return r.t_max; });
        moment = cross(origin, direction);
    }

    /// On which side of the line the rays pass, times a volume: one sixth of it is the tetrahedron of the line's and
    /// the ray's unit pieces.
    FloatLanes side(const Line& line) const {
        return line.direction.x * moment.x + line.direction.y * moment.y + line.direction.z * moment.z +
               line.moment.x * direction.x + line.moment.y * direction.y + line.moment.z * direction.z;
    }

    /// Where the rays meet the triangle. The side products are the barycentric weights, their sum is the determinant,
    /// and t = numerator / determinant; signs are such that the determinant is not negative.
    struct Crossing {
        FloatMask inside;
        FloatLanes weight_1, weight_2, determinant, numerator;
    };
    Crossing cross_triangle(const Triangle& t) const {
        const FloatLanes w0 = side(t.edges[0]), w1 = side(t.edges[1]), w2 = side(t.edges[2]);
        const FloatLanes sum = w0 + w1 + w2;
        const FloatLanes height = t.offset - (t.normal.x * origin.x + t.normal.y * origin.y + t.normal.z * origin.z);
        const FloatMask inside = (stdx::min(stdx::min(w0, w1), w2) >= 0) || (stdx::max(stdx::max(w0, w1), w2) <= 0);
        return {inside, w1, w2, stdx::fabs(sum), stdx::copysign(FloatLanes(1), sum) * height};
    }
};

void SmallSceneIntersector::closest_hits(std::span<const Ray> rays, std::span<Hit> hits, Coherence) const {
    assert(rays.size() == hits.size());
    for (size_t first = 0; first < rays.size(); first += kLanes) {
        const size_t count = std::min(kLanes, rays.size() - first);
        const RayLanes lanes(rays.subspan(first, count));
        // The nearest so far as a fraction, so that one division is left for the end.
        FloatLanes numerator = lanes.t_max, determinant = 1, weight_1 = 0, weight_2 = 0, index = -1;
        where(lanes.t_max > 1e30f, numerator) = 1e30f;  // infinity times a vanishing determinant is no number
        for (size_t k = 0; k < triangles_.size(); ++k) {
            const RayLanes::Crossing c = lanes.cross_triangle(triangles_[k]);
            const FloatMask nearer =
                c.inside && c.numerator > 0 && c.numerator * determinant < numerator * c.determinant;
            where(nearer, numerator) = c.numerator;
            where(nearer, determinant) = c.determinant;
            where(nearer, weight_1) = c.weight_1;
            where(nearer, weight_2) = c.weight_2;
            where(nearer, index) = float(k);
        }
        const FloatLanes scale = 1.0f / determinant;
        const FloatLanes t = numerator * scale, u = stdx::fabs(weight_1) * scale, v = stdx::fabs(weight_2) * scale;
        for (size_t i = 0; i < count; ++i) {
            const float k = index[i];
            if (k < 0) {
                hits[first + i] = {};
                continue;
            }
            const Triangle& triangle = triangles_[size_t(k)];
            hits[first + i] = {t[i], triangle.instance, triangle.triangle, u[i], v[i]};
        }
    }
}

void SmallSceneIntersector::occluded(std::span<const Ray> rays, std::span<uint8_t> occluded, Coherence) const {
    assert(rays.size() == occluded.size());
    for (size_t first = 0; first < rays.size(); first += kLanes) {
        const size_t count = std::min(kLanes, rays.size() - first);
        const RayLanes lanes(rays.subspan(first, count));
        FloatLanes t_max = lanes.t_max;
        where(t_max > 1e30f, t_max) = 1e30f;
        FloatMask blocked(false);
        for (const Triangle& triangle : triangles_) {
            const RayLanes::Crossing c = lanes.cross_triangle(triangle);
            blocked = blocked || (c.inside && c.numerator > 0 && c.numerator < t_max * c.determinant);
        }
        for (size_t i = 0; i < count; ++i) occluded[first + i] = blocked[i] ? 1 : 0;
    }
}

Hit SmallSceneIntersector::closest_hit(const Ray& ray) const {
    Hit hit;
    closest_hits({&ray, 1}, {&hit, 1}, Coherence::Incoherent);
    return hit;
}

bool SmallSceneIntersector::occluded(const Ray& ray) const {
    uint8_t blocked;
    occluded({&ray, 1}, {&blocked, 1}, Coherence::Incoherent);
    return blocked != 0;
}

uint64_t SmallSceneIntersector::bytes() const { return triangles_.capacity() * sizeof(Triangle); }

}  // namespace photond
