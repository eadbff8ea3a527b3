#include "renderer/methods/photon_splatting/splat_pilot.h"

#include "renderer/scene/scene.h"

namespace photond {

namespace {

constexpr uint32_t kPilotPhotons = 8192;
constexpr uint64_t kPilotSeed = 0x5a1f'0b1d'91c3'7e55;

}  // namespace

PilotSizes sizes_by_pilot(const SplatSettings& settings, const PhotonSplattingParams& params, const Scene& scene,
                          const Intersector& intersector, const EmissionSampler& emission, const PhotonTracing& tracing,
                          uint64_t seed, Stats& stats) {
    PilotSizes sizes{SplatSizes(settings.radius_m), BeamSizes(settings.beam_radius_m)};
    const bool casts = scene.needs.delta || scene.needs.glossy;
    std::vector<float> casters_m;
    if (casts) casters_m = caster_radii_m(scene, tracing.glossy_threshold);
    if (!settings.connects || !params.adaptive_size) {
        if (const std::string text = wide_beams_text(settings.beam_radius_m, casters_m); !text.empty())
            stats.skipped.push_back({"beams no wider than what casts them", text, 0});
        return sizes;
    }
    PhotonTracing tracing_pilot = tracing;
    tracing_pilot.photons = kPilotPhotons;
    // Numbers of its own: as little as the seed of a reference does this one show in the passes.
    const TracedReflections pilot = PhotonTracer(scene, intersector, emission, tracing_pilot)
                                        .trace_reflected(hash64(seed) ^ kPilotSeed, 0, CancelToken{});
    stats.counts.photon_rays += pilot.counts.photon_rays;  // none of them is a pass's
    sizes.splats = SplatSizes(settings.radius_m, scene.bounds, pilot, intersector, stats.counts);
    if (casts)
        sizes.beams =
            BeamSizes(settings.beam_radius_m, tracing.photons, std::move(casters_m), pilot, intersector, stats.counts);
    return sizes;
}

}  // namespace photond
