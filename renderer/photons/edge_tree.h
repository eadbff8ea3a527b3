#pragma once
// Where surfaces end, meet or turn sharply: a tree of the edges that most discs of density estimation leave after a few
// looks.

#include <span>
#include <vector>

#include "renderer/core/geometry.h"
#include "renderer/photons/disc_coverage_shared.h"

namespace photond {

/// From corner to corner of a triangle, in world space [m].
struct SurfaceEdge {
    vec3 a, b;
    /// Discs of at most that radius do not mind: the surface hardly bends there within them. [m]
    float harmless_m = 0;
};

class EdgeTree {
public:
    /// The same for any number of threads.
    explicit EdgeTree(std::vector<SurfaceEdge> edges);

    /// Whether an edge is within `radius_m` of p that a disc of that radius minds.
    bool has_edges(const vec3& p, float radius_m) const;

    uint64_t bytes() const { return nodes_.capacity() * sizeof(Node) + edges_.capacity() * sizeof(SurfaceEdge); }
    /// About what the edges of a scene of so many triangles may take.
    static uint64_t estimate_bytes(uint64_t triangles);

    /// For the twin in disc_coverage.glsl: nodes and then edges as words, and where they lie when the first of them has
    /// that number.
    std::vector<uint32_t> device_words() const;
    gpu::DiscCoverageConstants device_constants(uint32_t first_word) const;

private:
    /// Of a tree that is complete: node i has the children 2 i and 2 i + 1, the root is 1; the first half are inner
    /// nodes, the other half leaves.
    struct Node {
        Bounds3 box;
        float harmless_m;  // the least of its edges'
    };
    static constexpr size_t kLeafEdges = 4;  // at most

    /// Half open, of the edges: those of that leaf, or of the one of `parts` equal parts.
    size_t first_edge(size_t part, size_t parts) const { return part * edges_.size() / parts; }
    bool leaf_has_edges(size_t leaf, const vec3& p, float radius_m) const;

    std::vector<SurfaceEdge> edges_;
    size_t leaves_ = 0;  // a power of two; 0: no edge
    std::vector<Node> nodes_;
};

}  // namespace photond
