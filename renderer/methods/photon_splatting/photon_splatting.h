#pragma once
#include "renderer/frame/method.h"
#include "renderer/methods/photon_splatting/params.h"

namespace photond {

/// Photon splatting: photons light the visible points about their rays, by splats gathered in an image.
///
/// Each pass looks at the scene along one eye path a pixel: direct light at each vertex, specular parts followed,
/// visible points x left where a rough part waits (eye/specular_walk.h). `photons` light paths leave a photon at
/// each scattering y up to `bounces`, with power after reflection and a direction w drawn there; `stratify` keeps some
/// for each voxel. What a photon brings to x (derivations.md, "Splats that connect"; u the distance of x from the
/// photon's ray, K the filter, of unit integral over the plane across it):
///
///   connect     Phi K(u) cos_x V(y, x), cos_x towards y, for all x within a splat's radius h of the half-line. As y
///               sends light out by the cosine, int p(w) K(u) dw = cos_y / (pi d^2): the mean is the transport from y
///               to x for any h, without the bias of a kernel; so h may differ from place to place (splat_sizes.h).
///               Near y and its horizon the chance of passing is the form factor of a clipped sphere
///               (connect_weight.h). Nearer than a sixth of h the connection is clamped, and what that takes is found
///               by one short ray a visible point (`repay`, many_lights/clamp_repayment.h). A clamp at h would ask for
///               longer rays, which are noisier than the splats. Photons of rough BSDFs connect with their BSDF's
///               value. V is exact: the triangles that may stand in the shaft to a cluster of points are tested for all
///               its points at once, where they are few (transport/shaft_visibility.h), else by shadow rays.
///   kernel      Phi K(u) max(0, n . -w) V, V by an orthographic depth map across the ray (splat_depth_maps.h), for x
///               within a frustum about the hit of the ray. Blurs by h; darkens to half within h of edges. Consistent
///               with `shrink`. Delta and narrow lobes splat so with any estimator: caustics. Beside connections their
///               h follows where a pilot's photons land, and is no wider than what casts them (beam_sizes.h).
///   normalised  the thesis: colour max(0, n . -w) C K and weight K add up, their quotient is the pass's light. It
///               discards the density of photons: no exposure makes it converge to the truth.
///
/// Strong on diffuse interreflection: equal photons make equal contributions, so that 25 of them at a point come within
/// 30 % of the light. Weak where light comes through narrow glossy or specular parts, which blur (kernel), and where
/// everything is far apart compared to h, as few points then share a photon.
/// Without `repay` the clamp darkens corners. The layer `caustic` is not told apart. Not implemented: participating
/// media, dispersion; a camera inside a solid sees as if it were outside of it.
///
/// [Hoet 2014] Indirect Illumination using Photon Splatting. Thesis, Utrecht ("thesis" in the files beside this one).
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
    PassImage* end_pass() override;

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
