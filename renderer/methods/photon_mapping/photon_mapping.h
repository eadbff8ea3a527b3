#pragma once
#include <optional>

#include "renderer/methods/method.h"
#include "renderer/photons/photon_map.h"
#include "renderer/photons/radiance_estimate.h"
#include "renderer/transport/sobol.h"

namespace photond {

enum class Gather : uint8_t { Direct, Final };
enum class GatherSampling : uint8_t { Bsdf, Photons };
enum class DiscBoundary : uint8_t { None, Clip };

struct PhotonMappingParams final : MethodParams {
    uint32_t photons = 200'000;
    std::optional<uint32_t> caustic_photons;
    std::optional<uint32_t> indirect_bounces;
    Gather gather = Gather::Final;
    uint32_t gather_rays = 64;
    GatherSampling gather_sampling = GatherSampling::Bsdf;
    bool precompute_irradiance = false;
    bool shadow_photons = false;
    PhotonSearch::Kind search = PhotonSearch::Kind::Nearest;
    uint32_t nearest_photons = 50;
    std::optional<uint32_t> caustic_nearest_photons;
    std::optional<float> radius_m;
    std::optional<float> radius_relative;
    KernelShape kernel = KernelShape::Constant;
    float cone_k = 1.1f;
    std::optional<float> disc_thickness_m;
    bool soft_disc = false;
    DiscBoundary boundary = DiscBoundary::None;
    bool projection_maps = true;
    float glossy_threshold = 0.05f;
    SamplerKind sampler = SamplerKind::Sobol;
    bool keep_photon_map = false;

    void visit(ParamVisitor& visitor) override;
    /// `radius` and `radius_relative` exclude each other.
    void check() const override;

    /// Greatest number of scattering vertices of a path (conventions.md: n vertices make n - 1 bounces).
    uint32_t max_scatterings() const { return indirect_bounces ? *indirect_bounces + 1 : UINT32_MAX; }
    /// Of the maps, for a scene whose bounding sphere has that radius.
    float search_radius_m(float scene_radius_m) const;
};

/// Photon mapping: Jensen's two maps, as the slides and the thesis have them.
///
/// Each pass sends `photons` light paths (and `caustic_photons` towards specular surfaces, where there are any), stores
/// what arrives at surfaces with a lobe that is not specular, and then looks at the scene along one eye path a pixel.
/// At each vertex x the reflected light is split as the slides do (f_s: delta lobes and glossy ones with alpha below
/// `glossy_threshold`; f_d: all others; L_l light from the lights, L_c through specular scatterings only, L_d the rest):
///
///   L_r = int f L_l cos      A   light sampling, joined with B's direction by multiple importance sampling
///       + int f_s (L_c + L_d) B  the eye path goes on by BSDF sampling
///       + int f_d L_c cos    C   the caustic map
///       + int f_d L_d cos    D   the global map (gather: direct), or gather rays, at whose ends the outgoing radiance is
///                                direct + caustic + global (gather: final); rays that meet a specular surface follow it
///
/// Strong on caustics, also those seen in mirrors, which no path from the eye finds; noise is low-frequency. Biased by
/// the kernel's radius: density is smeared within it, and lost at edges unless `boundary` is "clip".
/// Not implemented: participating media (volume photon maps).
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
    void resolve(Film& film) override;

private:
    struct State;  // photon_mapping.cpp

    const PhotonMappingParams params_;
    std::unique_ptr<State> state_;
};

}  // namespace photond
