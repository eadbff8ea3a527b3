#pragma once
// LightDepthMaps on a device, where light_depth_maps.glsl looks them up.

#include "renderer/backends/gpu/counters.h"
#include "renderer/backends/gpu/device_scene.h"
#include "renderer/gbuffer/light_depth_maps.h"

namespace photond {

class LightDepthMapsGpu {
public:
    /// Traces the maps and waits: stage `shadow_maps`, counts.shadow_rays. Does not keep the scene. Throws
    /// ErrorCode::OutOfMemory where the device has no room.
    LightDepthMapsGpu(const gpu::DeviceScene& scene, uint32_t resolution, uint32_t pcf, Stats& stats);

    // What light_depth_maps.glsl binds.
    gpu::Buffer& constants() { return constants_; }  // LightDepthConstants
    gpu::Buffer& maps() { return maps_; }            // LightDepthMap, by punctual light; at least room for one
    gpu::Buffer& depths() { return depths_; }        // [m]; at least room for one

    static uint64_t device_bytes(const Scene& scene, uint32_t resolution);

private:
    gpu::Buffer constants_, maps_, depths_;
};

}  // namespace photond
