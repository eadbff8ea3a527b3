#pragma once
// The photons that light paths leave where they are reflected: what virtual lights and splats are made of.

#include "renderer/photons/photon_wavefront.h"
#include "renderer/photons/reflected_photon.h"

namespace photond {

/// What a batch leaves where its paths are reflected. The photons' `surface` counts from the batch's first.
struct ReflectedBatch {
    std::span<const ReflectedPhoton> photons;
    std::span<const uint32_t> elements;  // of the run: whose the photons are
    std::span<const ReflectingSurface> surfaces;
};

/// Scratch of one thread; reused from batch to batch.
class PhotonReflections {
public:
    /// Beside the wavefront's.
    static uint64_t bytes_per_thread();

    /// Traces the batch's paths up to their last scattering that counts and adds what they did to `counts`. What they
    /// leave there stays until the next call: ordered by scatterings, then plain Lambert reflectors before others, then
    /// by path.
    ReflectedBatch trace(PhotonWavefront& wavefront, const PhotonTracingScene& shared, const SequenceSampler& sampler,
                         const PhotonBatch& batch, Counts& counts);

private:
    /// What every step needs.
    struct Vertex {
        PhotonWavefront& wavefront;
        const PhotonTracingScene& shared;
        Counts& counts;
        uint32_t scatterings;  // before it
        bool goes_on;          // paths may have a vertex after it
    };

    void reflect_lambert(const Vertex& vertex);
    bool reflect_other(const Vertex& vertex, size_t place);
    void keep_rough(const Vertex& vertex, const PartedHit& parted, size_t place);
    void keep(const Vertex& vertex, uint32_t path, const ReflectedPhoton& photon);

    std::vector<ReflectedPhoton> photons_;  // these grow
    std::vector<uint32_t> elements_;
    std::vector<ReflectingSurface> surfaces_;
};

}  // namespace photond
