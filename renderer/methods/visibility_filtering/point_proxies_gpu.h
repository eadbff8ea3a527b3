#pragma once
// Point proxies [Chen 2014, section 3.1]: points on the scene's surfaces, drawn anew each pass and lit by all of its
// lights, in voxels whose light is known in sum. They stand for both what light comes from and what it is hidden by.
//
// [Chen et al. 2014] Visibility Filtering for Producing Indirect Illumination. Eurographics, short papers.

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/backends/gpu/prefix_sum.h"
#include "renderer/gbuffer/light_depth_maps_gpu.h"
#include "renderer/methods/visibility_filtering/proxy_placement_shared.h"
#include "renderer/photons/hash_grid_gpu.h"

namespace photond {

class PointProxiesGpu {
public:
    /// About `proxies` of them. Borrows the scene, which has surface, and the maps. `counters`: DeviceImage's.
    /// `depth_maps`: what tells of punctual lights; null: rays do.
    PointProxiesGpu(const gpu::DeviceScene& scene, LightDepthMapsGpu* depth_maps, gpu::Buffer& counters, uint64_t seed,
                    uint32_t proxies, float glossy_threshold);
    static uint64_t device_bytes(uint32_t proxies, uint32_t voxels_along, uint64_t triangles);
    /// How many there are where nothing is known of the scene's box: rooms are longer than high.
    static uint32_t guess_voxels(uint32_t along) { return along * along * along * 3 / 4; }

    /// `along`: voxels on the longest side of the scene's box; they are cubes, but for scenes that are flat. What was
    /// made before is gone where there are more of them than ever.
    void cut_voxels(uint32_t along);
    const gpu::HashGridConstants& grid() const { return grid_; }
    float cell_m() const { return cell_m_; }
    uint32_t words() const { return (grid_.slots + 31) / 32; }  // of a set of voxels
    float per_m2() const { return per_m2_; }

    /// A pass's proxies come in that many pieces, 0 ...; scope `vpl_generation`, then `voxelise`.
    uint32_t pieces() const;
    void record(gpu::CommandList& commands, uint32_t pass, uint32_t piece);
    /// Once a pass has been waited for.
    uint32_t count() const { return host_state_.as<const uint32_t>()[PROXIES_WORD]; }
    uint32_t nan_count() const { return host_state_.as<const uint32_t>()[PROXY_NAN_WORD]; }

    GridPhotons& sorted() { return *sorted_; }             // by voxel
    gpu::Buffer& voxels() { return voxels_; }              // ProxyVoxel
    gpu::Buffer& lit_words() { return lit_words_; }        // a bit a voxel that has light
    gpu::Buffer& running_sums() { return running_sums_; }  // of mean flux, by proxy, within its voxel

private:
    uint32_t proxies_a_piece() const;

    const gpu::DeviceScene& scene_;
    gpu::Device& device_;
    LightDepthMapsGpu* const depth_maps_;
    gpu::Buffer& counters_;
    const uint64_t seed_;
    const float glossy_threshold_;
    const uint32_t triangles_, capacity_;
    const float per_m2_;
    gpu::HashGridConstants grid_{};
    float cell_m_ = 0;
    uint32_t most_slots_ = 0;
    gpu::Buffer first_triangles_, starts_, state_, host_state_;
    UnsortedPhotons unsorted_;
    std::optional<GridPhotons> sorted_;
    gpu::Buffer voxels_, lit_words_, running_sums_;
    gpu::PrefixSum prefix_sum_;
    HashGridGpu hash_grid_;
    gpu::ComputePipeline counts_, places_, voxel_sums_;
};

}  // namespace photond
