#pragma once
// Lights chosen for each point (vpl_choice.h) on a device: points of a GBufferGpu, lights of a VplSetGpu. The same
// random numbers as on the CPU; points share a cut with those of their subgroup.

#include <optional>

#include "renderer/many_lights/vpl_choice_shared.h"
#include "renderer/many_lights/vpl_lighting_gpu.h"
#include "renderer/many_lights/vpl_tree_gpu.h"

namespace photond {

/// One of the two, and how many lights a point asks at most.
struct VplChoiceSettings {
    bool lightcut = false;  // else resampled
    uint32_t lights = 8;
};

/// Lights what VplLightingGpu would light, by its constants and visibility.
class VplChoiceGpu {
public:
    /// Throws ErrorCode::Unsupported for lightcut on a device with subgroups of fewer than 4 threads. Borrows all, of a
    /// split of side 1. `lighting`: for its constants(); `visibility`: the kind is read here.
    VplChoiceGpu(const gpu::DeviceScene& scene, GBufferGpu& buffer, VplSetGpu& lights, VplLightingGpu& lighting,
                 gpu::Buffer& counters, VplVisibility visibility, const VplChoiceSettings& settings);
    static uint64_t device_bytes(Size2 film_size, uint32_t most_lights, const VplChoiceSettings& settings);

    /// Once a pass, when its lights are known; scope `vpl_generation`.
    void record_lights(gpu::CommandList& commands);
    /// A pass is lit in that many pieces, 0 ..., each short enough for one submit; scope `indirect`.
    uint32_t pieces() const { return pieces_; }
    void record(gpu::CommandList& commands, const VplVisibilityGpu& visibility, uint32_t piece);
    /// What a piece costs, in paths.
    uint64_t paths_of_piece() const;

private:
    const VplChoiceSettings settings_;
    GBufferGpu& buffer_;
    VplSetGpu& lights_;
    VplLightingGpu& lighting_;
    gpu::Buffer& counters_;
    std::optional<VplTreeGpu> tree_;                   // of lightcut
    std::optional<gpu::ComputePipeline> copy_lights_;  // else
    const uint32_t points_at_once_, pieces_;
    gpu::Buffer chosen_, chosen_counts_, choice_lights_, cuts_;
    gpu::ComputePipeline choose_, light_;
};

}  // namespace photond
