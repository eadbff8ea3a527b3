#pragma once
#include "renderer/frame/method.h"
#include "renderer/methods/reverse_photon_mapping/photon_stream.h"

namespace photond {

/// Reverse photon mapping: final gathering in which photons look for the ends of gather rays, not these for photons.
///
/// A pass is photon_mapping's with `gather` "final", by the same code and the same random numbers: photons into maps,
/// eye paths, light samples, gather rays. Only what a ray's end has of the maps comes later. The end is kept as a
/// *reverse photon*: place, normal, what radiance there brings to its pixel, and the BSDF where that is more than
/// Lambert's. When a tile of them is full, they are sorted into cells and the maps' photons stream past, cell by cell:
/// neighbouring points seek their photons together, and one photon is added to eight points at a time. As high quality
/// asks for many more gather rays than photons, that saves most of the searching [Havran et al. 2005]. Points and
/// photons change roles against the paper, which has a tree of points that each photon is dropped into: which of the
/// two loops is the inner one does not change the pairs, and sums that stay in registers need no tree.
///
/// With a `fixed` radius the pairs of photon and point are photon_mapping's of the search `radius`, and the image is
/// the same but for rounding. With `knn` and `leaf` each photon has a disc of its own, as large as it must be to hold k
/// photons (`nearest_photons`; `caustic_nearest_photons`), by a search of the k nearest or by the size of its leaf in
/// the kd-tree and the photons there, at most `radius`; its kernel is normalised on that disc. What of a caustic the
/// eye sees without a gather ray between is looked up as photon_mapping does it: that is one lookup a pixel.
///
/// Strong where photon_mapping's final gathering is, and faster the more gather rays there are and the more photons lie
/// within the radius; with few rays points are too thin to share a search. It gains nothing on the rays themselves:
/// where tracing and shading them is most of the work (complex scenes with few photons) both cost about the same, and
/// photon_mapping's `precompute_irradiance` is faster than either, for a rougher image. With `boundary` "clip" points
/// within the radius of an edge are looked up one by one, as each has rays of its own to send; in furnished places
/// these are most.
/// Biased as photon_mapping is: by the radius, within which density is smeared, and at edges if `boundary` is "none".
/// With `knn` and `leaf` also by photons that reach further than where they lie is dense.
/// Memory is bounded by the photons and, for each thread, a tile of `tile_points` ends of rays, whatever the image and
/// the number of rays. Passes are averaged: noise falls with their number, bias with the radius only.
/// Not implemented: precomputed irradiance, which would take the lookups away that this is about; participating media;
/// dispersion; a GPU twin.
///
/// [Havran et al. 2005] Fast Final Gathering via Reverse Photon Mapping. Havran, Herzog and Seidel. Computer Graphics
/// Forum (Eurographics) 24(3).
class ReversePhotonMapping final : public Method {
public:
    static constexpr const char* kName = "reverse_photon_mapping";
    using Params = ReversePhotonMappingParams;

    explicit ReversePhotonMapping(const ReversePhotonMappingParams& params);
    ~ReversePhotonMapping() override;
    /// What begin() and the passes will record, to a few percent.
    static uint64_t estimate_bytes(const ReversePhotonMappingParams& params, const Workload& workload);

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;
    PassImage* end_pass() override;
    /// With `keep_photon_map`: the photons of the last whole pass.
    std::vector<MethodArtefact> artefacts() const override;

private:
    struct State;  // reverse_photon_mapping.cpp

    PhotonStream make_stream(const PhotonMap& map, uint32_t nearest, Stats& stats);

    const ReversePhotonMappingParams params_;
    std::unique_ptr<State> state_;
};

}  // namespace photond
