#pragma once
#include <vector>

#include "renderer/scene/intersector.h"

namespace photond {

/// Tests many rays at once against every triangle of a scene so small that a hierarchy costs more than it saves.
/// Measured on AMD Zen 4 with AVX-512, diffuse bounce rays in a box of 32 triangles: see the benchmark's table.
class SmallSceneIntersector final : public Intersector {
public:
    static constexpr uint64_t kMaxTriangles = 64;

    /// Whether all of the scene's surfaces are opaque, few, and of sizes that float tells apart.
    static bool suits(const Scene& scene);
    explicit SmallSceneIntersector(const Scene& scene);

    Hit closest_hit(const Ray& ray) const override;
    bool occluded(const Ray& ray) const override;
    void closest_hits(std::span<const Ray> rays, std::span<Hit> hits, Coherence coherence) const override;
    void occluded(std::span<const Ray> rays, std::span<uint8_t> occluded, Coherence coherence) const override;
    uint64_t bytes() const override;

private:
    /// A directed line in Pluecker coordinates.
    struct Line {
        vec3 direction;
        vec3 moment;
    };
    struct Triangle {
        Line edges[3];  // edges[i] lies opposite to corner i
        vec3 normal;    // not unit
        float offset;   // dot(normal, any corner)
        uint32_t instance;
        uint32_t triangle;
    };
    struct RayLanes;

    static Line line_between(const vec3& a, const vec3& b);

    std::vector<Triangle> triangles_;
};

}  // namespace photond
