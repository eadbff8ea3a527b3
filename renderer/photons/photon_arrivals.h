#pragma once
// The photons of light paths as they arrive at surfaces: what photon maps are made of.

#include "renderer/photons/photon_wavefront.h"

namespace photond {

/// What a thread's batches did.
struct PhotonCounts {
    Counts counts;
    uint64_t first_hits_specular = 0;
};

/// Scratch of one thread; reused from batch to batch.
class PhotonArrivals {
public:
    /// Beside the wavefront's.
    static uint64_t bytes_per_thread();

    /// Traces the batch's paths to their ends and adds what they did to `counts`. The photons stay until the next call:
    /// ordered by scatterings, then plain Lambert reflectors before others, then by path.
    std::span<const Photon> trace(PhotonWavefront& wavefront, const PhotonTracingScene& shared,
                                  const SequenceSampler& sampler, const PhotonBatch& batch, PhotonCounts& counts);

private:
    void shade_lambert(PhotonWavefront& wavefront, const PhotonTracingScene& shared, uint32_t scatterings,
                       Counts& counts);
    bool scatter_other(PhotonWavefront& wavefront, const PhotonTracingScene& shared, size_t place, uint32_t scatterings,
                       PhotonCounts& counts);
    void store(const PhotonWavefront& wavefront, uint32_t path, const vec3& position, const vec3& normal,
               uint32_t scatterings);

    uint64_t first_element_ = 0;   // of the batch's run
    std::vector<Photon> photons_;  // grows; the first photon_count_ count
    size_t photon_count_ = 0;
};

}  // namespace photond
