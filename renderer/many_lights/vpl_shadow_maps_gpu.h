#pragma once
// VplShadowMaps on a device.

#include <optional>

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/backends/gpu/device_tiles.h"
#include "renderer/many_lights/vpl_shadow_maps_shared.h"

namespace photond {

/// Borrows the scene and the counters (backends/gpu/counters.h), which it adds to. vpl_shadow_maps.glsl reads the maps;
/// imperfect_shadow_maps.h fills them otherwise.
class VplShadowMapsGpu {
public:
    /// Of at most `most_lights` at a time; `resolution` as VplShadowMaps'. Throws ErrorCode::OutOfMemory.
    VplShadowMapsGpu(const gpu::DeviceScene& scene, uint32_t resolution, uint32_t most_lights, gpu::Buffer& counters);

    /// The maps of the first `count` Vpl records; those past most_lights are left out. Scope `shadow_maps`.
    void record(gpu::CommandList& commands, gpu::Buffer& vpls, gpu::DeviceWord count);

    /// Light after light, row after row [m]: one float a texel.
    gpu::Buffer& reach() { return reach_; }
    uint32_t resolution() const { return push_.resolution; }
    uint32_t most_lights() const { return push_.most_lights; }
    static uint64_t device_bytes(uint32_t resolution, uint32_t most_lights) {
        return uint64_t{most_lights} * resolution * resolution * sizeof(float);
    }

private:
    const gpu::DeviceScene& scene_;
    gpu::VplMapPush push_;
    gpu::Buffer& counters_;
    gpu::Buffer reach_;
    std::optional<gpu::ComputePipeline> trace_;  // made when first needed
};

}  // namespace photond
