#pragma once
// The ray structure of the device, built on the host: Embree's binary tree, collapsed to compressed wide nodes
// (bvh_shared.h), which bvh.glsl traverses.

#include <span>
#include <vector>

#include "renderer/backends/gpu/bvh_shared.h"
#include "renderer/scene/intersector.h"

namespace photond::gpu {

struct BvhData {
    std::vector<BvhNode> nodes;          // BVH_NODES_BINDING; the root is the first; never empty
    std::vector<BvhTriangle> triangles;  // BVH_TRIANGLES_BINDING; never empty
    bool two_levels = false;             // BVH_TWO_LEVELS_ID: there are instances in the top tree
    uint32_t stack_entries = 0;          // the most a traversal can need
    double build_seconds = 0;

    uint64_t bytes() const { return nodes.size() * sizeof(BvhNode) + triangles.size() * sizeof(BvhTriangle); }
};

/// Triangles in world space, past which instanced meshes are kept once: these take some 60 MB.
inline constexpr uint64_t kMostCopiedTriangles = 1u << 20;

/// Whether build_bvh() keeps instanced meshes once.
bool has_two_levels(const Scene& scene, uint64_t most_copied_triangles = kMostCopiedTriangles);

/// One tree in world space, where that is not much larger than the scene: an instance in a tree costs every ray's every
/// step. Else (has_two_levels()) each mesh that has a transform has a tree of its own, and the top tree holds its
/// instances beside the triangles of all other meshes.
/// Throws ErrorCode::Unsupported, with the figure, when its traversal would need more stack than BVH_STACK.
BvhData build_bvh(const Scene& scene, uint64_t most_copied_triangles = kMostCopiedTriangles);

/// bvh.glsl's traversal on the host, one ray at a time: what its answers are compared with. Same meaning as
/// Intersector's.
Hit closest_hit(const BvhData& bvh, const Scene& scene, const Ray& ray);
bool occluded(const BvhData& bvh, const Scene& scene, const Ray& ray);

}  // namespace photond::gpu
