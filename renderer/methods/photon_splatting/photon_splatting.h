#pragma once
#include <optional>

#include "renderer/frame/method.h"
#include "renderer/photons/kernel.h"
#include "renderer/photons/photon_tracer.h"
#include "renderer/transport/sobol.h"

namespace photond {

enum class SplatWeighting : uint8_t { Normalised, Radiometric };
enum class SplatEstimator : uint8_t { Connect, Kernel };
enum class SplatFilter : uint8_t { Box, Tent, Gaussian };
enum class Representative : uint8_t { Random, ByPower, ClosestToMean, DominantDirection };
enum class BlurWidth : uint8_t { None, Three, Five, Seven, Nine };
/// Pixels across; 0: none.
constexpr uint32_t blur_pixels(BlurWidth width) {
    return width == BlurWidth::None ? 0 : 2 * static_cast<uint32_t>(width) + 1;
}

struct PhotonSplattingParams final : MethodParams {
    uint32_t photons = 10'000;
    uint32_t bounces = 1;
    PhotonInjection injection = PhotonInjection::Paths;
    uint32_t rays_per_photon = 1;
    bool stratify = false;
    uint32_t grid_cells = 64;
    uint32_t minimum_photons = 1;
    uint32_t splats_per_cell = 1;
    Representative representative = Representative::ByPower;
    std::optional<float> splat_size_m;
    std::optional<float> splat_size_relative;
    bool adaptive_size = true;
    SplatFilter filter = SplatFilter::Box;
    SplatWeighting weighting = SplatWeighting::Radiometric;
    SplatEstimator estimator = SplatEstimator::Connect;
    std::optional<float> step_back_m;
    std::optional<float> splat_depth_m;
    uint32_t shadow_resolution = 16;
    bool visibility = true;
    bool shrink = true;
    float alpha = 2.0f / 3.0f;
    bool repay = true;
    BlurWidth blur = BlurWidth::None;
    bool blur_edges = false;
    float ambient = 0;
    float indirect_exposure = 1;
    float glossy_threshold = 0.05f;
    float connect_threshold = 0.2f;
    SamplerKind sampler = SamplerKind::Sobol;

    void visit(ParamVisitor& visitor) override;
    /// Parameters that exclude each other.
    void check() const override;

    bool connects() const { return weighting == SplatWeighting::Radiometric && estimator == SplatEstimator::Connect; }
    /// Whether beams become narrower from pass to pass.
    bool shrinks() const { return shrink && weighting == SplatWeighting::Radiometric; }
    /// Of photons: lobes with GGX alpha below it send beams.
    float photon_threshold() const {
        return connects() ? std::max(connect_threshold, glossy_threshold) : glossy_threshold;
    }
    /// Greatest number of scattering vertices of a path (conventions.md: n vertices make n - 1 bounces).
    uint32_t max_scatterings() const { return bounces + 1; }
};

/// Photon splatting: photons light the visible points about their rays, by splats gathered in an image.
///
/// Each pass looks at the scene along one eye path a pixel: direct light at each vertex, specular parts followed,
/// visible points x left where a rough part waits (eye/specular_walk.h). `photons` light paths leave a photon at
/// each scattering y up to `bounces`, with power after reflection and a direction w drawn there; `stratify` keeps some
/// for each voxel. What a photon brings to x (derivations.md; u the distance of x from the photon's ray, K the filter,
/// of unit integral over the plane across it):
///
///   connect     Phi K(u) cos_x V(y, x), cos_x towards y, for all x within a splat's radius h of the half-line. As y
///               sends light out by the cosine, int p(w) K(u) dw = cos_y / (pi d^2): the mean is the transport from y
///               to x for any h, without the bias of a kernel; so h may differ from place to place (splat_sizes.h).
///               Near y and its horizon the chance of passing is the form factor of a clipped sphere
///               (connect_weight.h). Nearer than a sixth of h the connection is clamped, and what that takes is found
///               by one short ray a visible point (`repay`, repayment.h): derivations.md clamps at h, whose rays are
///               noisier than the splats. Photons of rough BSDFs connect with their BSDF's value. V is exact: the
///               triangles that may stand in the shaft to a cluster of points are tested for all its points at once,
///               where they are few (transport/shaft_visibility.h), else by shadow rays.
///   kernel      Phi K(u) max(0, n . -w) V, V by an orthographic depth map across the ray (splat_depth_maps.h), for x
///               within a frustum about the hit of the ray. Blurs by h; darkens to half within h of edges. Consistent
///               with `shrink`. Delta and narrow lobes splat so with any estimator: caustics.
///   normalised  the thesis: colour max(0, n . -w) C K and weight K add up, their quotient is the pass's light. It
///               discards the density of photons: no exposure makes it converge to the truth.
///
/// Strong on diffuse interreflection: equal photons make equal contributions, so that 25 of them at a point come within
/// 30 % of the light. Weak where light comes through narrow glossy or specular parts, which blur (kernel), and where
/// everything is far apart compared to h, as few points then share a photon.
/// Without `repay` the clamp darkens corners. The layer `caustic` is not told apart. Not implemented: participating
/// media, dispersion; a camera inside a solid sees as if it were outside of it.
///
/// The thesis, whose sections are cited in the files beside this one, is papers/photon-splatting.txt.
/// [Dachsbacher and Stamminger 2006] Splatting Indirect Illumination. I3D.
/// [Keller 1997] Instant Radiosity. SIGGRAPH.
/// [Kollig and Keller 2004] Illumination in the Presence of Weak Singularities (the clamp and its repayment).
class PhotonSplatting final : public Method {
public:
    static constexpr const char* kName = "photon_splatting";
    using Params = PhotonSplattingParams;

    explicit PhotonSplatting(const PhotonSplattingParams& params);
    ~PhotonSplatting() override;
    /// What begin() and the passes will record, to a factor of two; `splat_size` in metres is taken for the default.
    static uint64_t estimate_bytes(const PhotonSplattingParams& params, const Workload& workload);

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;
    void resolve(Film& film) override;

private:
    struct State;  // photon_splatting.cpp

    void look_from_eye(uint32_t pass, Stats& stats, const CancelToken& cancel);
    void splat_photons(uint32_t pass, Stats& stats, const CancelToken& cancel);
    void light_image(uint32_t pass, Stats& stats, const CancelToken& cancel);
    void blur(Stats& stats);

    const PhotonSplattingParams params_;
    std::unique_ptr<State> state_;
};

}  // namespace photond
