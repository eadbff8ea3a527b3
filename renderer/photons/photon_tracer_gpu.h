#pragma once
// PhotonTracer::trace() on a device: the same paths with the same numbers.

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/backends/gpu/radix_sort.h"
#include "renderer/photons/photon_shared.h"
#include "renderer/photons/photon_tracer.h"
#include "renderer/photons/photon_tracing_shared.h"

namespace photond {

/// Threads that follow light paths, each one after another: what a large card runs at once.
inline constexpr uint32_t kMostPathThreads = 1u << 17;

/// Photons as a tracer appended them, in whatever order its threads came; several tracers may use it in turn.
struct UnsortedPhotons {
    /// `capacity`: most photons of one map.
    UnsortedPhotons(gpu::Device& device, uint32_t capacity);
    static uint64_t bytes_for(uint64_t capacity);

    gpu::Buffer places, powers;  // PhotonPlace, PhotonPower
    gpu::Buffer paths;           // numbers of their paths in the pass; keys of the sort
    gpu::Buffer order;           // 0, 1, 2 ...; values of the sort
    gpu::RadixSort sort;
};

/// One pass's photons at a time. Borrows the scene. `tracing.guide` is read while this is made.
class PhotonTracerGpu {
public:
    PhotonTracerGpu(const gpu::DeviceScene& scene, const PhotonTracing& tracing);
    /// On the device, beside what it is handed.
    static uint64_t device_bytes(uint64_t instances, uint64_t guide_bytes);

    const PhotonTracing& tracing() const { return tracing_; }

    /// Before a pass's paths: nothing is stored yet.
    void record_start(gpu::CommandList& commands);
    /// Traces some of the pass's paths, half open, and appends at most `capacity` photons of the pass; more are counted
    /// alone.
    void record_paths(gpu::CommandList& commands, uint64_t seed, uint32_t pass, uint32_t first, uint32_t end,
                      UnsortedPhotons& photons, uint32_t capacity);

    /// Words of photon_tracing_shared.h: what the pass has done so far.
    gpu::Buffer& state() { return state_; }
    static constexpr uint64_t kStateBytes = PHOTON_STATE_WORDS * sizeof(uint32_t);
    /// Adds what those words of a whole pass say.
    void add_to(Counts& counts, std::span<const uint32_t> state) const;

private:
    const PhotonTracing tracing_;
    gpu::Buffer state_, stores_, guide_words_, guide_cdf_;
    gpu::ComputePipeline pipeline_;
};

}  // namespace photond
