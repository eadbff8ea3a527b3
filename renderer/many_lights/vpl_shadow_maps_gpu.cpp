#include "renderer/many_lights/vpl_shadow_maps_gpu.h"

namespace photond {

VplShadowMapsGpu::VplShadowMapsGpu(const gpu::DeviceScene& scene, uint32_t resolution, uint32_t most_lights,
                                   gpu::Buffer& counters)
    : scene_(scene),
      push_{.resolution = resolution, .count_word = 0, .most_lights = most_lights},
      counters_(counters),
      reach_(scene.device(), "shadow_maps", device_bytes(resolution, most_lights)) {}

void VplShadowMapsGpu::record(gpu::CommandList& commands, gpu::Buffer& vpls, gpu::DeviceWord count) {
    const gpu::Scope scope(commands, "shadow_maps");
    if (!trace_)
        trace_.emplace(scene_.device(), "renderer/many_lights/vpl_shadow_maps.comp", sizeof(gpu::VplMapPush),
                       &scene_.set(), scene_.specialization());
    commands.bind(*trace_, {gpu::read_write("device_counters", counters_), gpu::read("vpls", vpls),
                            gpu::read("counts", *count.buffer), gpu::write("reach_m", reach_)});
    gpu::VplMapPush push = push_;
    push.count_word = count.index;
    commands.push(push);
    commands.dispatch_threads(uint64_t{push.most_lights} * push.resolution * push.resolution, VPL_MAP_GROUP);
}

}  // namespace photond
