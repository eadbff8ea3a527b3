#pragma once
// What the texels of the lights' map see: the first vertices of their light paths, before any is dropped.

#include "renderer/photons/photon_wavefront.h"
#include "renderer/photons/reflected_photon.h"

namespace photond {

/// What a texel of the lights' map saw.
struct SeenTexel {
    uint32_t element;  // of the run
    /// At its hit, with all of the reflected power: by Lambert or rough lobes that leave light there, of Spread::Beam
    /// and without power where none does. `direction` is the normal, and no surface is kept.
    ReflectedPhoton photon;
    /// The greatest component of what a path may carry on from there [W]: by the lobes that leave light and, if paths
    /// go on from there, by all others.
    float flux_w;
};

/// Scratch of one thread; reused from batch to batch.
class SeenTexels {
public:
    /// Beside the wavefront's.
    static uint64_t bytes_per_thread() { return PhotonWavefront::kPaths * sizeof(SeenTexel); }

    /// The first hits of the batch's texels that reflect anything; they stay until the next call.
    std::span<const SeenTexel> see(PhotonWavefront& wavefront, const PhotonTracingScene& shared,
                                   const SequenceSampler& sampler, const PhotonBatch& batch, Counts& counts);

private:
    void see_other(const PhotonWavefront& wavefront, const PhotonTracingScene& shared, uint32_t path);

    std::vector<SeenTexel> seen_;
};

}  // namespace photond
