#pragma once
// kept_lists.h on a device: which points take over whose lists, and what that adds to their own.

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/backends/gpu/pipeline.h"
#include "renderer/gbuffer/gbuffer_gpu.h"
#include "renderer/methods/visibility_filtering/kept_lists.h"
#include "renderer/methods/visibility_filtering/point_proxies_gpu.h"
#include "renderer/voxels/sparse_voxel_octree_gpu.h"

namespace photond {

/// What rays of lists end at: the discs of the proxies, or the tree where there is one.
void append_ray_ends(std::vector<gpu::Binding>& bindings, PointProxiesGpu& proxies, SparseVoxelOctreeGpu* tree);

class KeptListsGpu {
public:
    /// Borrows all, but for what the frame before left: that is uploaded. The rest as of VisibilityListsGpu.
    KeptListsGpu(const gpu::DeviceScene& scene, GBufferGpu& points, PointProxiesGpu& proxies,
                 SparseVoxelOctreeGpu* tree, gpu::Buffer& constants, gpu::Buffer& counters,
                 const VisibilityFilteringParams& params, const ListsBetweenFrames& frames);
    static uint64_t device_bytes(const KeptLayout& layout);

    const gpu::KeptConstants& kept() const { return kept_; }
    gpu::Buffer& met_places() { return met_places_; }        // vec3 a ray
    gpu::Buffer& taking_points() { return taking_points_; }  // TakingPoint a list
    /// Adds to lists, half open, whose own rays have been shot, what they take over.
    void record(gpu::CommandList& commands, gpu::Buffer& lists, uint32_t first, uint32_t end);
    /// Once a pass's are all there, and once that has been waited for.
    void record_readback(gpu::CommandList& commands);
    void leave(ListsBetweenFrames& frames) const;

private:
    GBufferGpu& points_;
    PointProxiesGpu& proxies_;
    SparseVoxelOctreeGpu* const tree_;
    gpu::Buffer &constants_, &counters_;
    const gpu::KeptConstants kept_;
    gpu::Buffer kept_words_;  // what the frame before left
    gpu::Buffer met_places_, taken_places_, taking_points_;
    gpu::Buffer host_met_places_, host_taken_places_, host_taking_points_;
    gpu::ComputePipeline pipeline_;
};

}  // namespace photond
