#pragma once
// VplSet (vpl_set.h) on a device: a pass's reflected photons, in their order, as virtual point lights. How many there
// are only the device knows.

#include "renderer/backends/gpu/command_list.h"
#include "renderer/backends/gpu/device_scene.h"
#include "renderer/many_lights/vpl_set_shared.h"

namespace photond {

class VplSetGpu {
public:
    /// `most`: lights of a pass, at least 1; photons past it are left out. `connect_threshold`: lobes with GGX alpha
    /// below it send nothing. `likely`: what work is cut into pieces by where a pass may have far fewer.
    VplSetGpu(const gpu::DeviceScene& scene, uint32_t most, float connect_threshold, uint32_t likely = UINT32_MAX);
    static uint64_t device_bytes(uint32_t most, bool lambert);

    /// Photons as ReflectedPhotonsGpu and VplTracerGpu leave them, none a beam.
    struct Photons {
        gpu::Buffer &state, &photons, &order, &surfaces;
    };
    /// Scope `vpl_generation`.
    void record(gpu::CommandList& commands, const Photons& photons);
    /// Once that has been waited for.
    uint32_t lights_of_pass() const { return host_counts_.as<uint32_t>()[VPL_COUNT]; }

    uint32_t most() const { return most_; }
    uint32_t likely() const { return likely_; }
    gpu::Buffer& vpls() { return vpls_; }      // Vpl
    gpu::Buffer& lobes() { return lobes_; }    // VplLobes at Vpl::surface; one where every surface is Lambert
    gpu::Buffer& counts() { return counts_; }  // VPL_COUNT ...

private:
    const uint32_t most_, likely_;
    const float connect_threshold_;
    gpu::Buffer vpls_, lobes_, counts_, host_counts_;
    gpu::ComputePipeline gather_;
};

}  // namespace photond
