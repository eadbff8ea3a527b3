#pragma once
// Rays answered by a voxel tree: for photons and bounces that are traced through it. GLSL twin: svo_hit.glsl.

#include "renderer/scene/intersector.h"
#include "renderer/scene/scene.h"
#include "renderer/voxels/sparse_voxel_octree.h"

namespace photond {

/// The first set voxel along the ray stands for the surface: the hit is where the ray meets the plane of the voxel's
/// triangle, cut to the voxel's surroundings and to the triangle.
///
/// Biased: a hit lies up to two voxels off the true surface, along grazing rays further from the true
/// one; surfaces closer than that hide each other; a ray that passes
/// a silhouette within a voxel is stopped there; of several triangles in a voxel the one of least number answers;
/// masked and blended surfaces are whole (is_voxelised()).
///
/// Rays start and end on surfaces, whose voxels are set. An end in a set voxel is lifted off the plane of that voxel's
/// triangle by svo_lift(), to the side it lies on; on the plane (to a hundredth of a voxel), to the side the ray is on.
/// Near edges, where another triangle has the voxel, the plane is a neighbouring voxel's, where the end lies on that. A
/// ray that heads for the plane from off it is not moved: the voxel is its hit. Nothing is pulled in along the ray, so
/// that closed rooms stay closed; on curved surfaces some rays are stopped where they start (of segments that are
/// lifted at both ends, 7 % of dragon and buddha's unshadowed G at 128^3, 3 % at 256^3: svo_bench errors).
class VoxelIntersector final : public Intersector {
public:
    /// Borrows both; the tree has surfaces.
    VoxelIntersector(const Scene& scene, const SparseVoxelOctree& tree);

    Hit closest_hit(const Ray& ray) const override;
    bool occluded(const Ray& ray) const override;
    void closest_hits(std::span<const Ray> rays, std::span<Hit> hits, Coherence coherence) const override;
    void occluded(std::span<const Ray> rays, std::span<uint8_t> occluded, Coherence coherence) const override;

    uint64_t bytes() const override { return tree_.bytes(); }

private:
    TriangleCorners triangle(uint32_t number, uint32_t& instance, uint32_t& triangle) const;
    /// The plane of a surface that a point in a set voxel lies on: unit normal and the point's signed distance. False:
    /// it lies in no set voxel.
    bool plane_at(const vec3& position, vec3& normal, float& height) const;
    /// Where to start asking of a ray's end, `along` leading into the ray.
    vec3 away_from_surface(const vec3& position, const vec3& along) const;

    const Scene& scene_;
    const SparseVoxelOctree& tree_;
};

}  // namespace photond
