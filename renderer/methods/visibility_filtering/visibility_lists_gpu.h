#pragma once
// Which voxels of proxies some pixels see: sparse rays, a list of the voxels that they meet, and the visibility filter,
// which gives each list what those about it have [Chen et al. 2014, sections 3.1 and 3.2]. A list is a set of bits.

#include "renderer/gbuffer/gbuffer_gpu.h"
#include "renderer/methods/visibility_filtering/kept_lists_gpu.h"
#include "renderer/methods/visibility_filtering/params.h"
#include "renderer/methods/visibility_filtering/point_proxies_gpu.h"
#include "renderer/methods/visibility_filtering/visibility_lists_shared.h"
#include "renderer/voxels/sparse_voxel_octree_gpu.h"

namespace photond {

class VisibilityListsGpu {
public:
    /// Borrows all. `tree`: what rays meet; null: the proxies' discs. `counters`: DeviceImage's. `kept`: what lists
    /// take over from the frame before, and where what they leave is gathered; null: they stand alone.
    VisibilityListsGpu(const gpu::DeviceScene& scene, GBufferGpu& points, PointProxiesGpu& proxies,
                       SparseVoxelOctreeGpu* tree, gpu::Buffer& constants, gpu::Buffer& counters,
                       const VisibilityFilteringParams& params, KeptListsGpu* kept);
    static uint64_t device_bytes(Size2 size, const VisibilityFilteringParams& params);
    /// How many lists there are along either axis.
    static Size2 lists_of(Size2 size, uint32_t march_subsampling);

    /// Lists of so many voxels; those of before are gone where there is more to be kept than ever. Throws
    /// ErrorCode::OutOfMemory for more words than can be numbered.
    void make_room(uint32_t voxels);
    /// Words of a list of so many voxels, before the filter and after it.
    static uint32_t words_before(ListKind kind, uint32_t voxels);
    static uint32_t words_after(ListKind kind, uint32_t voxels);

    /// A pass's lists come in that many pieces, 0 ..., after its proxies; scopes `march` and `visibility_filter`.
    uint32_t pieces() const;
    uint64_t paths_of_piece() const { return uint64_t{lists_a_piece()} * rays_; }
    void record(gpu::CommandList& commands, uint32_t piece);

    gpu::Buffer& before_filter() { return before_filter_; }
    gpu::Buffer& lists() { return lists_; }

private:
    uint32_t count() const { return static_cast<uint32_t>(size_.pixels()); }
    uint32_t lists_a_piece() const;
    void record_march(gpu::CommandList& commands, uint32_t first, uint32_t end);
    void record_expected(gpu::CommandList& commands, uint32_t first, uint32_t end);

    gpu::Device& device_;
    GBufferGpu& points_;
    PointProxiesGpu& proxies_;
    SparseVoxelOctreeGpu* const tree_;
    KeptListsGpu* const kept_;
    gpu::Buffer &constants_, &counters_;
    const Size2 size_;
    const uint32_t rays_;
    const ListKind kind_;
    gpu::Buffer before_filter_, lists_;
    gpu::ComputePipeline march_;
    const std::unique_ptr<gpu::ComputePipeline> expected_;  // null: rays are not counted
    gpu::ComputePipeline filter_;
};

}  // namespace photond
