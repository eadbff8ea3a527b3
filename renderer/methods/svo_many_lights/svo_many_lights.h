#pragma once
#include "renderer/frame/follows_frames.h"
#include "renderer/frame/method.h"
#include "renderer/many_lights/incremental_vpls.h"
#include "renderer/methods/svo_many_lights/params.h"
#include "renderer/photons/neighbours.h"

namespace photond {

/// Many lights with sparse-voxel-octree visibility: virtual point lights where direct light falls, and a G-buffer whose
/// pixels ask a share of them each. The thesis [Sun 2015], stage for stage, and past it (methods.md,
/// "svo_many_lights").
///
/// A pass: each light's reflective shadow map is traced, a Halton set is warped by the flux of its texels, and the
/// light paths chosen so leave `vpls` lights at their first surfaces and, with `bounces`, at further ones
/// (many_lights/vpl_tracer.h). Where most light is in another room, paths are better chosen by what they bring to the
/// picture (`placement` acceptance, metropolis: many_lights/path_selection.h). From the eye, specular parts are
/// followed to one visible point a pixel, with direct light on the way (gbuffer.h). A point asks the lights of its
/// place in an n x n block (`interleave`), all of them
/// (`vpl_choice` resampled, lightcut), by V of `visibility`; connections nearer than sqrt(B) are clamped, and what that
/// takes is found by one short ray a point (clamp_repayment.h, layer `clamped`). The next pass has other lights, and
/// other pixels ask them: with `visibility` rays and `repay`, and without `filter`, the mean over the passes is the
/// light's transport up to `bounces`: what narrow lobes (GGX alpha below `connect_threshold`, mirrors, glass) send
/// towards a visible point does not connect, and is found by the same short ray, which has no end then (`narrow_lobes`,
/// where a scene has such). Caustics, light that came by specular scatterings alone (GGX alpha below
/// `glossy_threshold`), are looked up in a map of `caustic_photons` instead, at the visible points and at the vertices
/// of those rays' paths (photons/caustic_photons.h): blurred within a radius that shrinks from pass to pass, so that
/// the mean converges. With none they are path traced: no bias, and fireflies.
///
/// Strong where light is smooth: a thousand lights light every pixel, and the octree answers for V without the scene.
/// Weak: voxels darken within about a voxel of edges and contacts, and between thin things (the interior of the
/// built-in scene by a tenth at 256^3), and leak where both ends are within two voxels of a thin wall, those near a
/// point alone (`near_field`) leak wherever what shadows it is farther; `clamp` = 0
/// makes the variance at corners infinite. The layer `caustic` is not told apart. Not implemented: participating media,
/// dispersion.
///
/// With `incremental` all passes of a frame have lights that frames hand on instead (many_lights/incremental_vpls.h).
///
/// [Sun 2015] Many-Light Real-Time Global Illumination using Sparse Voxel Octree. Thesis, WPI.
/// [Keller 1997] Instant Radiosity. SIGGRAPH. [Kollig and Keller 2004] Illumination in the Presence of Weak
/// Singularities. [Clarberg et al. 2005] Wavelet Importance Sampling. SIGGRAPH.
class SvoManyLights final : public FollowsFrames<Method, VplsBetweenFrames> {
public:
    static constexpr const char* kName = "svo_many_lights";
    using Params = SvoManyLightsParams;

    explicit SvoManyLights(const SvoManyLightsParams& params);
    ~SvoManyLights() override;
    /// What begin() and the passes will record, to a factor of two.
    static uint64_t estimate_bytes(const SvoManyLightsParams& params, const Workload& workload);

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;
    PassImage* end_pass() override;

private:
    struct State;  // svo_many_lights.cpp

    void look_from_eye(uint32_t pass, Stats& stats, const CancelToken& cancel);
    void make_caustics(const RenderContext& context, Stats& stats);
    TracedReflections trace_lights(uint32_t pass, Stats& stats, const CancelToken& cancel);
    void make_lights(uint32_t pass, Stats& stats, const CancelToken& cancel);
    void send_caustic_photons(uint32_t pass, Stats& stats, const CancelToken& cancel);
    void gather_caustics(uint32_t first, uint32_t end, Neighbours& scratch);
    void light_points(uint32_t pass, Stats& stats, const CancelToken& cancel);
    void merge(Stats& stats);
    bool repays() const;

    const SvoManyLightsParams params_;
    std::unique_ptr<State> state_;
};

}  // namespace photond
