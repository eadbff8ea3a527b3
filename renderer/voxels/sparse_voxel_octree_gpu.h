#pragma once
// SparseVoxelOctree made on a device, by the thesis's passes (4.3): fragments, then the tree level by level, each by
// dispatches as large as what was counted on the device. Departures: triangles are cut into columns of bricks instead
// of rasterised, so that a wall and a crumb load the device evenly and no voxel is missed; tiles are allocated by
// prefix sums instead of an atomic counter, so that the arrays are the CPU's bit for bit.

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/backends/gpu/prefix_sum.h"
#include "renderer/voxels/voxel_grid.h"

namespace photond {

class SparseVoxelOctreeGpu {
public:
    /// Borrows the scene. Builds nothing yet; room is made by the first build_now().
    SparseVoxelOctreeGpu(const gpu::DeviceScene& scene, const VoxelGrid& grid, bool surfaces);

    /// Builds, waits, and makes room until there is enough. Stages `voxelise` and `svo_build`.
    void build_now(Stats& stats);
    /// Builds anew within a frame, without a wait; scopes `voxelise` and `svo_build`. Once that has been waited for,
    /// grow_if_short() says whether the room that build_now() made was enough.
    void record_build(gpu::CommandList& commands);
    /// Once a recorded build has been waited for: true where there was too little room. Now there is, and it must be
    /// built again. Throws ErrorCode::OutOfMemory where the device cannot hold it.
    bool grow_if_short();

    // For shaders that include svo_march.glsl. They stay the same until grow_if_short() says true or build_now() comes.
    gpu::Buffer& constants() { return constants_buffer_; }
    gpu::Buffer& nodes() { return nodes_; }
    gpu::Buffer& bricks() { return bricks_; }
    gpu::Buffer& surfaces() { return surfaces_; }                // a word without surfaces
    gpu::Buffer& first_triangles() { return first_triangles_; }  // for svo_hit.glsl

    const gpu::SvoConstants& host_constants() const { return constants_; }
    // Of the last build waited for.
    uint64_t voxel_count() const;
    uint64_t node_count() const;
    uint64_t brick_count() const;
    uint64_t fragment_count() const;

    /// Of the tree itself, and with what building it takes.
    uint64_t device_bytes() const;
    uint64_t device_bytes_with_scratch() const;
    /// device_bytes() over set voxels.
    double bytes_a_voxel() const;

private:
    gpu::Device& device_;
    const gpu::DeviceScene& scene_;
    gpu::SvoConstants constants_;
    gpu::Buffer constants_buffer_, nodes_, bricks_, surfaces_, first_triangles_;
};

}  // namespace photond
