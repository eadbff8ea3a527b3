#pragma once
// Direct light apart from its shadow, on a device: what light a pixel's first surface would send to the eye if nothing
// were in between, and how far from it the first thing is that hides the middle of that light. One shadow ray a pixel,
// whatever the light's size: what is made of it is the method's.
//
// All pixels choose their light by the same number, so that neighbours mostly have the same. The environment, which has
// no middle, and what is seen by mirrors and glass are left to shadow rays.

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/gbuffer/centre_shadows_shared.h"

namespace photond {

class CentreShadowsGpu {
public:
    CentreShadowsGpu(const gpu::DeviceScene& scene, Size2 size);
    /// `lights`: Workload's.
    static uint64_t device_bytes(Size2 size, uint64_t lights);

    gpu::Buffer& shapes() { return shapes_; }  // LampShape; at least room for one
    gpu::Buffer& words() { return words_; }    // which lamp a light is: lamps_shared.h
    gpu::Buffer& lights() { return lights_; }  // UnshadowedLight, pixel by pixel

private:
    gpu::Buffer shapes_, words_, lights_;
};

}  // namespace photond
