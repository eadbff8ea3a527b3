#include <bit>
#include <cstring>

#include "renderer/backends/gpu/bvh.h"
#include "renderer/scene/alpha_test.h"
#include "renderer/scene/scene.h"
#include "renderer/scene/surface_color.h"

namespace photond::gpu {

namespace {

/// One ray's way through the arrays, in double precision where bvh.glsl has to be careful with rounding.
class Traversal {
public:
    Traversal(const BvhData& bvh, const Scene& scene, const Ray& ray, bool any)
        : bvh_(bvh), scene_(scene), ray_(ray), any_(any), nearest_(ray.t_max) {
        if (ray.t_max > 0) visit(0, {dvec3(ray.origin), dvec3(ray.direction), kNoHit});
    }
    const Hit& hit() const { return hit_; }

private:
    struct LocalRay {
        dvec3 origin, direction;
        uint32_t instance;  // kNoHit: world space
    };

    static uint32_t byte_of(const uint32_t (&words)[2], uint32_t i) { return words[i / 4] >> (8 * (i % 4)) & 255; }

    bool done() const { return any_ && hit_.valid(); }

    void visit(uint32_t index, const LocalRay& ray) {
        const BvhNode& node = bvh_.nodes[index];
        const uint32_t octant =
            (ray.direction.x < 0 ? 4u : 0u) | (ray.direction.y < 0 ? 2u : 0u) | (ray.direction.z < 0 ? 1u : 0u);
        for (uint32_t order = 8; order-- > 0 && !done();) {
            const uint32_t slot = order ^ octant, meta = byte_of(node.meta, slot);
            if (meta == 0 || !meets_box(node, slot, ray)) continue;
            const uint32_t is_node = node.scales >> 24;
            if (is_node >> slot & 1)
                visit(node.nodes + uint32_t(std::popcount(is_node & ((1u << slot) - 1))), ray);
            else
                for (uint32_t i = 0; meta >> (5 + i) & 1 && i < 3; ++i)
                    meet(bvh_.triangles[node.triangles + (meta & 31) + i], ray);
        }
    }

    bool meets_box(const BvhNode& node, uint32_t slot, const LocalRay& ray) const {
        const uint32_t low[3] = {byte_of(node.low_x, slot), byte_of(node.low_y, slot), byte_of(node.low_z, slot)};
        const uint32_t high[3] = {byte_of(node.high_x, slot), byte_of(node.high_y, slot), byte_of(node.high_z, slot)};
        double enter = 0, leave = nearest_;
        for (int axis = 0; axis < 3; ++axis) {
            const double spacing = std::bit_cast<float>((node.scales >> (8 * axis) & 255) << 23);
            const double lower = node.grid_origin[axis] + low[axis] * spacing - ray.origin[axis];
            const double upper = node.grid_origin[axis] + high[axis] * spacing - ray.origin[axis];
            const double d = ray.direction[axis];
            if (d == 0 && (lower > 0 || upper < 0)) return false;
            if (d == 0) continue;
            enter = std::max(enter, std::min(lower / d, upper / d));
            leave = std::min(leave, std::max(lower / d, upper / d));
        }
        return enter <= leave;
    }

    void meet(const BvhTriangle& record, const LocalRay& ray) {
        if (record.kind == BVH_INSTANCE) {
            uint32_t place;
            std::memcpy(&place, &record.corners, sizeof place);
            BvhTransform transform;
            std::memcpy(static_cast<void*>(&transform), &bvh_.triangles[place], sizeof transform);
            const glm::dmat4x3 from_world(transform.from_world);
            visit(record.triangle,
                  {from_world * glm::dvec4(ray.origin, 1), from_world * glm::dvec4(ray.direction, 0), record.instance});
            return;
        }
        // On which side of each edge the ray passes, by volumes [Moeller and Trumbore 1997, by Pluecker's order].
        const dvec3 a = dvec3(record.corners[0]) - ray.origin, b = dvec3(record.corners[1]) - ray.origin,
                    c = dvec3(record.corners[2]) - ray.origin;
        const double wa = glm::dot(ray.direction, glm::cross(c, b)), wb = glm::dot(ray.direction, glm::cross(a, c)),
                     wc = glm::dot(ray.direction, glm::cross(b, a)), sum = wa + wb + wc;
        if (!((wa >= 0 && wb >= 0 && wc >= 0) || (wa <= 0 && wb <= 0 && wc <= 0)) || sum == 0) return;
        const double t =
            glm::dot(wa * a + wb * b + wc * c, ray.direction) / (sum * glm::dot(ray.direction, ray.direction));
        if (!(t > 0 && t < nearest_)) return;
        const uint32_t instance = ray.instance != kNoHit ? ray.instance : record.instance;
        const auto u = static_cast<float>(wb / sum), v = static_cast<float>(wc / sum);
        if (record.kind == BVH_COVERED_IN_PART &&
            passes_surface(
                ray_, instance, record.triangle,
                surface_coverage(scene_, scene_.meshes[scene_.instances[instance].mesh], record.triangle, u, v)))
            return;
        nearest_ = t;
        hit_ = {static_cast<float>(t), instance, record.triangle, u, v};
    }

    const BvhData& bvh_;
    const Scene& scene_;
    const Ray& ray_;
    const bool any_;
    double nearest_;
    Hit hit_;
};

}  // namespace

Hit closest_hit(const BvhData& bvh, const Scene& scene, const Ray& ray) {
    return Traversal(bvh, scene, ray, false).hit();
}

bool occluded(const BvhData& bvh, const Scene& scene, const Ray& ray) {
    return Traversal(bvh, scene, ray, true).hit().valid();
}

}  // namespace photond::gpu
