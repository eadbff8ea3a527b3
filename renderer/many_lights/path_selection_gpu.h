#pragma once
// The paths of a pass's lights, selected (path_selection.h) on a device: the same candidates, targets and chains. A
// target that rounding moves across a decision makes another path of it, in few passes and to no one's harm.

#include "renderer/backends/gpu/prefix_sum.h"
#include "renderer/gbuffer/gbuffer_gpu.h"
#include "renderer/many_lights/flux_map_gpu.h"
#include "renderer/many_lights/path_selection.h"
#include "renderer/many_lights/vpl_set_gpu.h"
#include "renderer/many_lights/vpl_tracer_gpu.h"

namespace photond {

/// Between a tracer's record_map() and what takes its lights, in place of record_vpls(). Borrows all but the pilot.
class PathSelectionGpu {
public:
    /// `counters`: DeviceImage's. The points have been seen before a pass's lights are selected.
    PathSelectionGpu(const gpu::DeviceScene& scene, VplTracerGpu& tracer, GBufferGpu& buffer, gpu::Buffer& counters,
                     VplPlacement placement, const PathPilot& pilot, uint32_t vpls, uint64_t seed, float clamp_sq_m2);
    /// About, as the pilot decides.
    static uint64_t device_bytes(VplPlacement placement, uint32_t vpls);

    /// A pass is recorded in that many pieces, 0 ..., scope `vpl_generation`.
    uint32_t pieces() const { return rounds_ + (chains() ? shape_.states : 0) + 1; }
    /// What a piece costs, in paths.
    uint64_t paths_of_piece() const;
    void record(gpu::CommandList& commands, uint32_t pass, uint32_t piece);
    /// After VplSetGpu::record(): what choices among the lights take each for.
    void record_choices(gpu::CommandList& commands, VplSetGpu& lights);
    /// What was offered and accepted, once the pass has been waited for.
    void add_to(Counts& counts) const;

private:
    bool chains() const { return placement_ == VplPlacement::Metropolis; }
    gpu::PathSelectionPush push(uint32_t pass, uint32_t step) const;
    void rate(gpu::CommandList& commands, uint32_t pass, gpu::Buffer& paths, uint32_t first, uint32_t count,
              gpu::Buffer& targets);
    void record_candidates(gpu::CommandList& commands, uint32_t pass, uint32_t round);
    void record_acceptance(gpu::CommandList& commands, uint32_t pass);
    void record_starts(gpu::CommandList& commands, uint32_t pass);
    void record_step(gpu::CommandList& commands, uint32_t pass, uint32_t step);

    VplTracerGpu& tracer_;
    GBufferGpu& buffer_;
    gpu::Buffer& counters_;
    const VplPlacement placement_;
    const PathPilot pilot_;
    const uint32_t vpls_, rounds_;
    const uint64_t seed_;
    const float clamp_sq_m2_;
    const ChainShape shape_;
    FluxMapGpu targets_;  // of the candidates; their sums are chains' alone
    gpu::Buffer candidates_, selected_, kept_, proposed_, proposed_targets_, chain_states_, counts_, host_counts_;
    std::optional<gpu::PrefixSum> sum_;
    gpu::ComputePipeline find_candidates_, rate_, set_choices_;
    std::optional<gpu::ComputePipeline> accept_, thin_;           // of acceptance
    std::optional<gpu::ComputePipeline> start_, propose_, step_;  // of chains
};

}  // namespace photond
