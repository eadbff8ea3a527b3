#include "renderer/many_lights/flux_map_gpu.h"

#include "renderer/many_lights/flux_map.h"

namespace photond {

FluxMapGpu::FluxMapGpu(gpu::Device& device, uint32_t levels)
    : levels_(levels),
      sums_(device, "flux_map", device_bytes(levels)),
      sum_(device, "renderer/many_lights/flux_map_sum.comp", sizeof(gpu::FluxLevelsPush)) {}

uint64_t FluxMapGpu::device_bytes(uint32_t levels) { return FluxMap::values(levels) * sizeof(float); }

void FluxMapGpu::record_sum(gpu::CommandList& commands) {
    for (uint32_t level = 0; level < levels_; level += FLUX_MAP_GROUP_LEVELS) {
        commands.bind(sum_, {gpu::read_write("sums", sums_)});
        commands.push(gpu::FluxLevelsPush{level, levels_});
        commands.dispatch_threads(uint64_t{1} << 2 * (levels_ - level - 1), FLUX_MAP_GROUP);
    }
}

}  // namespace photond
