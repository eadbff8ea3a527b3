#pragma once
// Virtual point lights: where light leaves surfaces, placed by what the lights' maps see (texel_map.h), with flux that
// is about the same for all. What they become is many_lights/vpl.h's business.
//
// Each texel of the map is traced to its first hit. What it reflects there makes a pyramid of flux (flux_map.h), by
// which a Halton set, rotated from pass to pass, chooses texels; the light path of a chosen texel is traced on as
// PhotonTracer::trace_reflected() does. [Keller 1997; Dachsbacher and Stamminger 2006; svo-many-lights, 4.8]
//
// [Keller 1997] Instant Radiosity. SIGGRAPH.
// [Dachsbacher and Stamminger 2006] Splatting Indirect Illumination. I3D.

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "renderer/many_lights/flux_map.h"
#include "renderer/many_lights/vpl_tracer_shared.h"
#include "renderer/photons/photon_tracer.h"
#include "renderer/photons/photon_wavefront.h"
#include "renderer/photons/texel_map.h"
#include "renderer/transport/roulette_shared.h"

namespace photond {

struct VplTracing {
    uint32_t vpls = 1024;     // light paths a pass
    uint32_t map_side = 128;  // texels, a power of two up to 1024; all lights share the map
    uint32_t bounces = 1;     // most scatterings that leave light
    /// Alpha: narrower lobes leave no light. Like all that transmits they only send paths on.
    float connect_threshold = 0.2f;
    SamplerKind sampler = SamplerKind::Sobol;
    /// Whether the paths' numbers after their first rays know nothing of one another.
    bool independent_paths = false;
};

/// About how many lights a pass has for so many light paths and bounces: in rooms each bounce leaves three fifths of
/// those before it (1.6 to 2.1 lights a path in the built-in ones where bounces have no end).
inline uint64_t expected_vpls(uint64_t paths, uint32_t bounces) {
    constexpr double kKept = 0.6;
    const double lights = (1 - std::pow(kKept, static_cast<double>(bounces))) / (1 - kKept);
    return static_cast<uint64_t>(std::ceil(static_cast<double>(paths) * lights));
}

/// Room for the lights of a pass. Roulette keeps a path with a probability of 0.98 at most: where a white scene
/// lets it, paths have fifty surfaces in the mean, and their sum passes this by a chance below 1e-9.
inline uint64_t most_vpls(uint64_t paths, uint32_t bounces) {
    constexpr double kMostMean = 1 / (1 - double{ROULETTE_MOST_SURVIVAL});
    const double n = static_cast<double>(paths);
    const auto most = static_cast<uint64_t>(kMostMean * (n + 8 * std::sqrt(n) + 24));
    return std::min(paths * std::max(bounces, 1u), most);
}

/// A factor on the flux that a texel is chosen by: not negative. The photon: position, normal and reflected power_w of
/// the texel's hit; it has one scattering, its direction is the normal. Called from several threads at a time.
using TexelImportance = std::function<float(const ReflectedPhoton&)>;

/// What share of the lights stays with the texels' plain flux where there is an importance beside it: what lights is
/// never left out.
inline constexpr float kPlainFluxShare = 0.25f;

/// Light paths that were chosen before they are traced.
struct ChosenPaths {
    std::vector<ChosenStart> starts;  // VplTracing::vpls of them
    std::vector<uint32_t> order;      // where each is in the order in which they come back
};
/// What a photon brings to wherever light is wanted, by any scale: what of it is seen there, and all.
struct PhotonWorth {
    float seen = 0, unshadowed = 0;
};
/// Finds that for each photon. `elements`: of their paths' numbers. How many rays it took. Called from several threads
/// at a time.
using RatePhotons = std::function<uint64_t(std::span<const ReflectedPhoton> photons, std::span<const uint32_t> elements,
                                           std::span<PhotonWorth> worth)>;
/// Of each path, the sum over its photons if it were one of VplTracing::vpls; weights and choices are not looked at.
using RatePaths = std::function<std::vector<PhotonWorth>(std::span<const gpu::VplPath> paths)>;
/// What a pass's lights are left by.
struct SelectedPaths {
    std::vector<gpu::VplPath> paths;     // at most VplTracing::vpls
    uint64_t offered = 0, accepted = 0;  // of those that were to be decided on
};
using SelectPaths = std::function<SelectedPaths(const uvec2& rotation, const RatePaths& rate)>;

/// Borrows scene, intersectors and emission.
class VplTracer {
public:
    /// First hits are found by `intersector`, all others by `bounce_intersector`.
    VplTracer(const Scene& scene, const Intersector& intersector, const Intersector& bounce_intersector,
              const EmissionSampler& emission, const VplTracing& tracing);
    ~VplTracer();

    /// One pass's lights: a pure function of (scene, settings, seed, pass), at most vpls x bounces of them, none of
    /// Spread::Beam. They come along the curve of the map (path after path, and along each by its scatterings), so that
    /// every n-th of them are spread as well as all. `importance` may be empty. Stages `rsm` and `vpl_generation`; the
    /// counts are in what comes back. Cancelled: what comes back is incomplete and must not be used.
    TracedReflections trace(uint64_t seed, uint32_t pass, const TexelImportance& importance, Stats& stats,
                            const CancelToken& cancel) const;
    /// The same with the paths that `select` chooses, by what `worth` says of their photons.
    TracedReflections trace_selected(uint64_t seed, uint32_t pass, const RatePhotons& worth, const SelectPaths& select,
                                     Stats& stats, const CancelToken& cancel) const;

    /// The same of paths that are given, with the numbers of the first pass of that seed after their first hits. Stage
    /// `vpl_generation`.
    TracedReflections trace(uint64_t seed, const ChosenPaths& paths, Stats& stats, const CancelToken& cancel) const;

    const TexelMap& map() const;
    /// A texel's own numbers.
    TexelMapPass::TexelNumbers numbers_of(const TexelMapPass& pass, uint32_t texel) const;
    /// What the texels of that pass's map reflect, summed.
    FluxMap see_flux(const TexelMapPass& pass, Counts& counts) const;
    /// What the first hits of paths reflect: the greatest component of each [W], 0 for nothing. At most
    /// SequenceSampler::kRun of them; may be called from several threads at a time.
    void see(std::span<const ChosenStart> starts, std::span<float> flux_w, Counts& counts) const;

    /// The random numbers of a pass's texels, by their places.
    static SequenceSampler texel_numbers(const VplTracing& tracing, const TexelMapPass& pass) {
        return {tracing.sampler, pass.seed(), RandomDomain::Photons, 0};
    }
    /// The random numbers of a pass's paths after their first rays, in the order in which paths were chosen.
    static SequenceSampler path_numbers(const VplTracing& tracing, const TexelMapPass& pass) {
        return {tracing.independent_paths ? SamplerKind::Random : tracing.sampler, pass.seed(), RandomDomain::Photons,
                1};
    }

    /// About the area that light reaches without a bounce [m^2], by the texels of one map; 0 where it reaches nothing.
    double lit_area_m2(uint64_t seed) const;

    /// Bytes of scratch; `lights` with power, triangles one by one.
    static uint64_t scratch_bytes(const VplTracing& tracing, size_t threads, uint64_t lights);
    /// Of what trace() gives, as many lights as are expected.
    static uint64_t result_bytes(const VplTracing& tracing);

private:
    struct Shared;
    std::unique_ptr<Shared> shared_;
};

}  // namespace photond
