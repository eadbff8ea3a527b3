#pragma once
// FluxMap's pyramid on a device (flux_map.glsl reads it).

#include "renderer/backends/gpu/command_list.h"
#include "renderer/many_lights/flux_map_shared.h"

namespace photond {

class FluxMapGpu {
public:
    FluxMapGpu(gpu::Device& device, uint32_t levels);

    uint32_t levels() const { return levels_; }
    uint32_t texels() const { return 1u << 2 * levels_; }
    /// A float each: the texels' worth, then the sums, level above level; the last is the total.
    gpu::Buffer& sums() { return sums_; }
    /// From the texels' worth.
    void record_sum(gpu::CommandList& commands);

    static uint64_t device_bytes(uint32_t levels);

private:
    uint32_t levels_;
    gpu::Buffer sums_;
    gpu::ComputePipeline sum_;
};

}  // namespace photond
