#include "renderer/gbuffer/light_depth_maps_gpu.h"

#include <algorithm>

namespace photond {

namespace {

constexpr const char* kStructure = "shadow_maps";

}  // namespace

LightDepthMapsGpu::LightDepthMapsGpu(const gpu::DeviceScene& scene, uint32_t resolution, uint32_t pcf, Stats& stats) {
    const StageTimer timer(stats, kStructure);
    gpu::Device& device = scene.device();
    const LightDepthLayout layout(scene.scene(), resolution, pcf);
    constants_ = gpu::Buffer(device, kStructure, sizeof layout.constants);
    maps_ = gpu::Buffer(device, kStructure, std::max<size_t>(layout.maps.size(), 1) * sizeof(gpu::LightDepthMap));
    depths_ = gpu::Buffer(device, kStructure, std::max<uint64_t>(layout.texels, 1) * sizeof(float));
    gpu::upload(device, constants_, std::as_bytes(std::span(&layout.constants, 1)));
    if (layout.maps.empty()) return;
    gpu::upload(device, maps_, std::as_bytes(std::span(layout.maps)));

    const gpu::ComputePipeline trace(device, "renderer/gbuffer/light_depth_maps.comp", sizeof(gpu::LightDepthPush),
                                     &scene.set(), scene.specialization());
    gpu::CommandList commands(device);
    const uint32_t at_once = device.paths_per_submit();
    for (uint64_t first = 0; first < layout.texels; first += at_once) {
        const auto end = static_cast<uint32_t>(std::min<uint64_t>(first + at_once, layout.texels));
        if (first > 0) commands.reset();
        {
            const gpu::Scope scope(commands, kStructure);
            commands.bind(
                trace, {gpu::read("constants", constants_), gpu::read("maps", maps_), gpu::write("depths_m", depths_)});
            commands.push(gpu::LightDepthPush{static_cast<uint32_t>(first), end});
            commands.dispatch_threads(end - first, LIGHT_DEPTH_GROUP);
        }
        commands.submit();
        commands.wait();
        commands.add_times(stats);
    }
    stats.counts.shadow_rays += layout.texels;
}

uint64_t LightDepthMapsGpu::device_bytes(const Scene& scene, uint32_t resolution) {
    return sizeof(gpu::LightDepthConstants) +
           std::max<uint64_t>(LightDepthMaps::bytes_for(scene, resolution), sizeof(float) + sizeof(gpu::LightDepthMap));
}

}  // namespace photond
