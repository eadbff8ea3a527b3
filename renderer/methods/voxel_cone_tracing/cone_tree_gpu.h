#pragma once
// A voxel octree with light in it, on a device: a pass's photons light its voxels, and what is seen of eight cells from
// each side becomes what is seen of the one about them.

#include "renderer/many_lights/photons_by_cell_gpu.h"
#include "renderer/methods/voxel_cone_tracing/cone_tree_shared.h"
#include "renderer/voxels/kept_voxels_gpu.h"

namespace photond {

class ConeTreeGpu {
public:
    /// Makes the tree, and what there is room for: where the tree follows from a frame before, it may be under way.
    /// Finds out how much of each voxel is covered; waits for that. `most`: photons of a pass. Borrows the scene.
    /// Stages `voxelise`, `svo_build` and `svo_update`.
    ConeTreeGpu(const gpu::DeviceScene& scene, const VoxelGrid& grid, uint32_t most, Stats& stats,
                KeptVoxels* kept = nullptr);
    /// Where nothing is known of the scene but its triangles' number.
    static uint64_t guess_device_bytes(uint32_t resolution, uint32_t most, uint64_t triangles);

    /// FrameOctreeGpu::settle(): true where the pass has to be made again.
    bool settle(Stats& stats);

    /// The light of a pass: scopes `inject` and `filter_up`.
    void record(gpu::CommandList& commands, VplTracerGpu& photons);

    /// What cone_cells.glsl asks for.
    void append_lit_to(std::vector<gpu::Binding>& bindings);
    gpu::Buffer& cells() { return cells_; }  // ConeCell: voxels, eights of bricks, bricks, nodes
    const gpu::ConeTreeConstants& layout() const { return host_constants_; }

private:
    /// All of it but the cells.
    void append_to(std::vector<gpu::Binding>& bindings);
    void make_cells(Stats& stats);
    void find_places(Stats& stats);
    gpu::ConeTreeConstants constants() const;

    const gpu::DeviceScene& scene_;
    const uint32_t most_;
    FrameOctreeGpu tree_;
    gpu::ConeTreeConstants host_constants_;
    gpu::Buffer constants_, table_, cells_;
    std::optional<PhotonsByCellGpu> by_voxel_;  // once there are cells
    gpu::ComputePipeline light_voxels_, filter_;
};

}  // namespace photond
