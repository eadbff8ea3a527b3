#pragma once
// VplLighting (vpl_lighting.h) on a device: the points of a GBufferGpu lit by the lights of a VplSetGpu. The same
// lights are asked by the same random numbers as on the CPU; where nothing is asked (VplVisibility::None), none are
// dropped by chance.

#include <optional>
#include <string>

#include "renderer/gbuffer/gbuffer_gpu.h"
#include "renderer/many_lights/vpl_lighting_shared.h"
#include "renderer/many_lights/vpl_set_gpu.h"
#include "renderer/many_lights/vpl_shadow_maps_gpu.h"
#include "renderer/voxels/sparse_voxel_octree_gpu.h"

namespace photond {

enum class VplVisibility : uint8_t;  // vpl_lighting.h

/// Who answers for V on a device. Shaders that ask come one a kind, NAME_rays.comp and so on; their other buffers have
/// bindings below VPL_VISIBILITY_BINDING.
struct VplVisibilityGpu {
    VplVisibility kind{};
    SparseVoxelOctreeGpu* tree = nullptr;  // of Svo and NearField
    VplShadowMapsGpu* maps = nullptr;      // of ShadowMaps

    /// `stem`: "renderer/many_lights/vpl_lighting". `kind`: of it alone.
    static std::string shader(const std::string& stem, VplVisibility kind);
    /// Appends what the shader of this kind binds beside the others.
    void append_to(std::vector<gpu::Binding>& bindings) const;
};

struct VplLightingSettings {
    VplVisibility visibility{};
    float clamp_sq_m2 = 0;  // B; 0: none
    float roulette = 0;
    float connect_threshold = 0.2f;
    uint32_t map_resolution = 0;      // of VplVisibility::ShadowMaps
    float voxel_reach_m = kInfinity;  // as VplPass's
    bool lights_all = true;           // false: for constants() alone, others light by them
};

class VplLightingGpu {
public:
    /// Borrows the points and the lights. `counters`: DeviceImage's.
    VplLightingGpu(const gpu::DeviceScene& scene, GBufferGpu& buffer, VplSetGpu& lights, gpu::Buffer& counters,
                   uint64_t seed, const VplLightingSettings& settings);
    static uint64_t device_bytes() { return sizeof(gpu::VplLightingConstants); }

    /// Of a pass, before what reads constants().
    void record_constants(gpu::CommandList& commands, uint32_t pass);
    /// A pass is lit in that many pieces, 0 ..., each short enough for one submit; scope `indirect`.
    uint32_t pieces() const { return point_pieces_ * light_pieces_; }
    void record(gpu::CommandList& commands, const VplVisibilityGpu& visibility, uint32_t piece);
    /// What a piece costs, in paths.
    uint64_t paths_of_piece() const;

    gpu::Buffer& constants() { return constants_; }  // VplLightingConstants

    /// Which subsets the tiles of a pass take (VplSubsets::assign()).
    static uint32_t rotation(uint64_t seed, uint32_t pass, uint32_t tiles);

private:
    GBufferGpu& buffer_;
    VplSetGpu& lights_;
    gpu::Buffer& counters_;
    const uint64_t seed_;
    const VplLightingSettings settings_;
    const uint32_t lights_at_once_, points_at_once_, point_pieces_, light_pieces_;
    gpu::Buffer constants_;
    std::optional<gpu::ComputePipeline> light_;
};

}  // namespace photond
