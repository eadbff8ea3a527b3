#pragma once
// A voxel octree with light in it, on a device: a pass's photons light its voxels, and what is seen of eight cells from
// each side becomes what is seen of the one about them.

#include "renderer/many_lights/photons_by_cell_gpu.h"
#include "renderer/methods/voxel_cone_tracing/cone_tree_shared.h"
#include "renderer/voxels/kept_voxels_gpu.h"

namespace photond {

class ConeTreeGpu {
public:
    /// Makes the tree and finds out how much of each voxel is covered; waits. `most`: photons of a pass. Borrows the
    /// scene. Stages `voxelise`, `svo_build` and `svo_update`.
    ConeTreeGpu(const gpu::DeviceScene& scene, const VoxelGrid& grid, uint32_t most, Stats& stats,
                KeptVoxels* kept = nullptr);
    /// Where nothing is known of the scene but its triangles' number.
    static uint64_t guess_device_bytes(uint32_t resolution, uint32_t most, uint64_t triangles);

    /// The light of a pass: scopes `inject` and `filter_up`.
    void record(gpu::CommandList& commands, VplTracerGpu& photons);

    /// What cone_cells.glsl asks for.
    void append_lit_to(std::vector<gpu::Binding>& bindings);
    gpu::Buffer& cells() { return cells_; }  // ConeCell: voxels, eights of bricks, bricks, nodes
    const gpu::ConeTreeConstants& layout() const { return host_constants_; }
    uint64_t voxels() const { return tree_->voxel_count(); }

private:
    /// All of it but the cells.
    void append_to(std::vector<gpu::Binding>& bindings);
    void find_places(Stats& stats);
    gpu::ConeTreeConstants constants() const;

    const gpu::DeviceScene& scene_;
    const std::shared_ptr<SparseVoxelOctreeGpu> tree_;
    const gpu::ConeTreeConstants host_constants_;
    gpu::Buffer constants_, table_, cells_;
    PhotonsByCellGpu by_voxel_;
    gpu::ComputePipeline light_voxels_, filter_;
};

}  // namespace photond
