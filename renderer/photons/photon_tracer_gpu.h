#pragma once
// PhotonTracer::trace() on a device: the same paths with the same numbers, unless they start from a bounce map.

#include <optional>

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
    /// `bounce_map_texels`: where light first arrives that the pass's photons leave from together, each as many, give
    /// or take one; 0: each photon traces its own way from the light. At most as many as there are photons.
    PhotonTracerGpu(const gpu::DeviceScene& scene, const PhotonTracing& tracing, uint32_t bounce_map_texels = 0);
    /// On the device, beside what it is handed and the bounce map.
    static uint64_t device_bytes(uint64_t instances, uint64_t guide_bytes);
    static uint64_t bounce_map_bytes(uint32_t texels) { return uint64_t{texels} * sizeof(gpu::FirstHit); }

    const PhotonTracing& tracing() const { return tracing_; }

    /// Before a pass's paths: nothing is stored yet.
    void record_start(gpu::CommandList& commands);
    /// Some of the pass's texels of the bounce map, half open; all of them come before the paths.
    void record_bounce_map(gpu::CommandList& commands, uint64_t seed, uint32_t pass, uint32_t first, uint32_t end);
    uint32_t bounce_map_texels() const { return texels_; }
    gpu::Buffer& bounce_map() { return first_hits_; }  // FirstHit; at least room for one
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
    SequenceSampler sequence_of(uint64_t seed) const;

    const PhotonTracing tracing_;
    const uint32_t texels_;
    gpu::Buffer state_, stores_, guide_words_, guide_cdf_, first_hits_;
    gpu::ComputePipeline pipeline_;
    std::optional<gpu::ComputePipeline> bounces_;
};

}  // namespace photond
