#pragma once
// CausticPhotons (caustic_photons.h) on a device: the same photons with the same numbers, in a grid of cells.
// caustic_lookup.glsl looks them up.

#include "renderer/backends/gpu/command_list.h"
#include "renderer/photons/caustic_photons.h"
#include "renderer/photons/photon_maps_gpu.h"
#include "renderer/photons/radiance_estimate_shared.h"

namespace photond {

class CausticPhotonsGpu {
public:
    /// Borrows the scene; `host` is read while this is made, and for the radii of passes.
    CausticPhotonsGpu(const gpu::DeviceScene& scene, std::unique_ptr<CausticPhotons> host, uint64_t seed);
    /// Where each light path leaves so many photons, beside what the scene's instances take.
    static uint64_t device_bytes(const CausticSettings& settings, double yield, uint64_t lights);

    /// A pass's photons come in that many pieces, 0 ..., each short enough for one submit; with the last one the map is
    /// built. Scopes `photon_tracing` and `photon_map_build`.
    uint32_t pieces() const { return maps_.pieces(PHOTON_MAP_CAUSTIC); }
    void record(gpu::CommandList& commands, uint32_t pass, uint32_t piece);
    /// Of a whole pass: true where there was too little room for its photons. Now there is, and it is to be done again.
    bool grow_if_short();
    void add_to(Counts& counts) const { maps_.add_to(counts, PHOTON_MAP_CAUSTIC); }

    /// What caustic_lookup.glsl reads.
    void append_to(std::vector<gpu::Binding>& bindings);

private:
    const std::unique_ptr<CausticPhotons> host_;
    const uint64_t seed_;
    PhotonMapsGpu maps_;  // one
    gpu::Buffer estimate_;
};

/// Stands where there is no such map, for shaders that then look nothing up.
class NoCausticPhotons {
public:
    explicit NoCausticPhotons(gpu::Device& device);
    static uint64_t device_bytes() { return sizeof(gpu::EstimateConstants); }
    void append_to(std::vector<gpu::Binding>& bindings);

private:
    gpu::Buffer nothing_;
};

}  // namespace photond
