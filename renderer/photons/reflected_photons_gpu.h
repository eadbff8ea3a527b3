#pragma once
// PhotonTracer::trace_reflected() on a device: the same paths with the same numbers, and the photons they leave.

#include <optional>

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/backends/gpu/prefix_sum.h"
#include "renderer/photons/photon_tracer.h"
#include "renderer/photons/reflected_photon_shared.h"
#include "renderer/photons/reflective_shadow_map.h"

namespace photond {

/// One pass's photons at a time. Borrows the scene, the emission and the counters (backends/gpu/counters.h), which it
/// adds to.
///
/// Photon i of the pass, in an order that is the same every time, is photons()[order()[i]]: path after path, and along
/// each by its scatterings. Room for them is made by what paths leave in a furnished room; a pass that leaves more is
/// traced again after grow_if_short().
class ReflectedPhotonsGpu {
public:
    ReflectedPhotonsGpu(const gpu::DeviceScene& scene, const EmissionSampler& emission, const PhotonTracing& tracing,
                        gpu::Buffer& counters);
    /// Photons of a pass that room is made for at first.
    static uint32_t expected_photons(const PhotonTracing& tracing);
    /// On the device, at first. `lambert`: every surface is a plain Lambert reflector.
    static uint64_t device_bytes(const PhotonTracing& tracing, bool lambert);

    /// Says which pass is traced next, and returns the number of its paths. What the pass leaves is a pure function of
    /// (scene, settings, seed, pass).
    uint32_t start(uint64_t seed, uint32_t pass);
    /// Sets the counters of the pass; recorded before all paths.
    void record_start(gpu::CommandList& commands);
    /// Traces the paths [first, end), stage `photon_tracing`.
    void record_paths(gpu::CommandList& commands, uint32_t first, uint32_t end);
    /// Puts the photons in their order; recorded after all paths.
    void record_order(gpu::CommandList& commands);

    /// Called once the pass has been waited for: true where there was too little room. Now there is enough, and the
    /// pass is to be begun anew by start().
    bool grow_if_short();
    uint32_t photons_of_pass() const { return counted(REFLECTION_PHOTONS); }
    /// Samples that were no numbers.
    void add_to(Counts& counts) const;

    gpu::Buffer& state() { return state_; }  // words, REFLECTION_PHOTONS ...
    gpu::Buffer& photons() { return photons_; }
    gpu::Buffer& order() { return order_; }
    gpu::Buffer& surfaces() { return surfaces_; }

private:
    uint32_t counted(uint32_t word) const { return host_state_.as<uint32_t>()[word]; }
    void make_room(uint32_t photons, uint32_t surfaces);

    gpu::Device& device_;
    const PhotonTracing tracing_;
    gpu::Buffer& counters_;
    std::optional<ReflectiveShadowMaps> maps_;
    uint32_t photon_capacity_ = 0, surface_capacity_ = 0;
    gpu::ReflectionPush push_{};
    uint32_t paths_ = 0;  // of the pass
    gpu::Buffer state_, host_state_, photons_, owners_, order_, surfaces_, path_counts_, grids_;
    gpu::ComputePipeline trace_, sort_;
    gpu::PrefixSum sum_;
};

}  // namespace photond
