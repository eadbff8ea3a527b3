#include "renderer/gbuffer/centre_shadows_gpu.h"

#include <algorithm>

#include "renderer/gbuffer/lamps.h"

namespace photond {

CentreShadowsGpu::CentreShadowsGpu(const gpu::DeviceScene& scene, Size2 size)
    : lights_(scene.device(), "unshadowed_light", size.pixels() * sizeof(gpu::UnshadowedLight)) {
    const Lamps lamps = find_lamps(scene.scene());
    shapes_ = gpu::Buffer(scene.device(), "unshadowed_light",
                          std::max<uint64_t>(lamps.shapes.size(), 1) * sizeof(gpu::LampShape));
    if (!lamps.shapes.empty()) gpu::upload(scene.device(), shapes_, std::as_bytes(std::span(lamps.shapes)));
    words_ = gpu::Buffer(scene.device(), "unshadowed_light", lamps.words.size() * sizeof(uint32_t));
    gpu::upload(scene.device(), words_, std::as_bytes(std::span(lamps.words)));
}

uint64_t CentreShadowsGpu::device_bytes(Size2 size, uint64_t lights) {
    return size.pixels() * sizeof(gpu::UnshadowedLight) + lights * (sizeof(gpu::LampShape) + sizeof(uint32_t)) +
           sizeof(uint32_t);
}

}  // namespace photond
