#pragma once
#include "renderer/frame/method.h"
#include "renderer/methods/photon_mapping/params.h"

namespace photond {

/// Photon mapping: Jensen's two maps, as [Gumhold] and [Hoet 2014, 4.5] have them.
///
/// Each pass sends `photons` light paths (and `caustic_photons` towards specular surfaces, where there are any), stores
/// what arrives at surfaces with a lobe that is not specular, and then looks at the scene along one eye path a pixel.
/// At each vertex x the reflected light is split as [Gumhold] does (f_s: delta lobes and glossy ones with alpha below
/// `glossy_threshold`; f_d: all others; L_l light from the lights, L_c light that came through specular scatterings
/// only, L_d the rest):
///
///   L_r = int f L_l cos      A   light samples; f_s's share joined with B, f_d's with gather rays that meet lights,
///                                by multiple importance sampling
///       + int f_s (L_c + L_d) B  the eye path goes on by sampling f_s
///       + int f_d L_c cos    C   the caustic map
///       + int f_d L_d cos    D   the global map (gather: direct), or gather rays drawn by f_d (gather: final)
///
/// At the end y of a gather ray the light that f_d scatters is direct + caustic + global; f_s there is followed. What
/// f_s at y scatters of L_l and L_c came through specular scatterings only: it is C's at x, and not added. Where a ray
/// is shorter than the radius of the global map's lookup at y, in corners, f_d at y is sampled for one more bounce
/// instead of that lookup. Direct light at y has one light sample, and where f_d is more than Lambert's one ray
/// drawn by f_d beside it.
///
/// Strong on caustics, also those seen in mirrors, which no path from the eye finds; noise is low-frequency. Biased by
/// the kernel's radius: density is smeared within it, and lost at edges if `boundary` is "none". Passes are
/// averaged: noise falls with their number, bias with the radius only.
/// Where `shadow_photons` is on, shadows smaller than the distance of photons can be missed; it saves four of five
/// shadow rays in a Cornell box, but pays only where a ray costs more than a search among photons. With
/// `precompute_irradiance` surfaces at the ends of gather rays count as Lambert reflectors of their albedo.
/// Not implemented: participating media (volume photon maps), dispersion; a camera inside a solid sees as if it were
/// outside of it.
///
/// [Jensen 1996] Global Illumination using Photon Maps. Eurographics Workshop on Rendering.
/// [Jensen 1995] Importance Driven Path Tracing using the Photon Map. Eurographics Workshop on Rendering.
/// [Jensen and Christensen 1995] Efficiently Rendering Shadows using the Photon Map. Compugraphics.
/// [Christensen 1999] Faster Photon Map Global Illumination. Journal of Graphics Tools 4(3).
class PhotonMapping final : public Method {
public:
    static constexpr const char* kName = "photon_mapping";
    using Params = PhotonMappingParams;

    explicit PhotonMapping(const PhotonMappingParams& params);
    ~PhotonMapping() override;
    /// What begin() and the passes will record, to a few percent: most of it are the photons.
    static uint64_t estimate_bytes(const PhotonMappingParams& params, const Workload& workload);

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;
    PassImage* end_pass() override;
    /// With `keep_photon_map`: the photons of the last whole pass.
    std::vector<MethodArtefact> artefacts() const override;

private:
    struct State;  // photon_mapping.cpp

    const PhotonMappingParams params_;
    std::unique_ptr<State> state_;
};

}  // namespace photond
