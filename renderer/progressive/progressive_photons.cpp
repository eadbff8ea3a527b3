#include "renderer/progressive/progressive_photons.h"

#include <algorithm>

#include "renderer/core/thread_local.h"
#include "renderer/gathering/expected_photons.h"
#include "renderer/photons/caustic_photons.h"
#include "renderer/photons/photon_guides.h"
#include "renderer/scene/scene.h"
#include "renderer/transport/light_sampling.h"

namespace photond {

namespace {

constexpr uint64_t kPilotSeed = reference_seed(0x9106);

/// Why the scene and the parameters need no such photons; nullptr: they do.
const char* why_not(PhotonMapKind kind, const ProgressiveParams& params, bool lights, bool specular) {
    if (!lights) return "the scene has no light";
    if (params.photon_scatterings(1) == 0) return "indirect_bounces is 0";
    if (kind == PhotonMapKind::Caustic && !specular) return "no specular surface";
    return nullptr;
}

uint64_t light_count(const Scene& scene) { return scene.triangle_lights.size() + scene.punctual_lights.size(); }

}  // namespace

struct ProgressivePhotons::Emission {
    explicit Emission(const Scene& scene) : sampler(scene) {}

    EmissionSampler sampler;
    PhotonGuides guides;
};

ProgressivePhotons::ProgressivePhotons(const RenderContext& context, const ProgressiveParams& params, Stats& stats)
    : context_(context), params_(params) {
    const Scene& scene = context.scene;
    const StageTimer timer(stats, "photon_emission");
    if (light_count(scene) > 0 || scene.environment) {
        emission_ = std::make_unique<Emission>(scene);
        if (!(emission_->sampler.total_power_w() > 0)) emission_.reset();
    }
    const bool specular = has_specular_surface(scene, params.glossy_threshold);
    for (const PhotonMapKind kind : kPhotonMapKinds) {
        const uint32_t paths = this->paths(kind);
        if (const char* why = why_not(kind, params, emission_ != nullptr, specular)) {
            const double stored = yield_of(kExpectedPhotonYield, kind).unguided * paths;
            stats.skipped.push_back(
                {std::string(name_of(kind)) + " map", why, PhotonMap::bytes_for(static_cast<uint64_t>(stored))});
            continue;
        }
        if (params.projection_maps)
            emission_->guides.add(kind, scene, *context.intersector, emission_->sampler, params.glossy_threshold,
                                  context.seed, context.budget, stats);
        tracers_[index_of(kind)] =
            std::make_unique<const PhotonTracer>(scene, *context.intersector, emission_->sampler, tracing(kind));
    }
    if (!any()) {
        emission_.reset();
        return;
    }
    context.budget.record("emission_sampler", emission_->sampler.bytes());
    context.budget.record("photon_tracer", PhotonTracer::scratch_bytes(most_threads()));
}
ProgressivePhotons::~ProgressivePhotons() = default;

PhotonTracing ProgressivePhotons::tracing(PhotonMapKind kind) const {
    return {.kind = kind,
            .photons = paths(kind),
            .most_scatterings = params_.photon_scatterings(1),
            .glossy_threshold = params_.glossy_threshold,
            .sampler = params_.sampler,
            .guide = emission_->guides.of(kind)};
}

uint64_t ProgressivePhotons::pilot_seed() const { return hash64(context_.seed) ^ kPilotSeed; }

PhotonMap ProgressivePhotons::trace(PhotonMapKind kind, uint32_t pass, const PhotonSearch& search, Stats& stats,
                                    const CancelToken& cancel) {
    if (!wanted(kind)) return {};
    TracedPhotons traced;
    {
        const StageTimer timer(stats, "photon_tracing");
        traced = tracers_[index_of(kind)]->trace(context_.seed, pass, cancel);
    }
    stats.counts += traced.counts;
    if (cancel.cancelled()) return {};
    MemoryBudget& budget = context_.budget;
    const std::string structure = std::string(name_of(kind)) + "_map";
    const uint64_t peak_bytes = PhotonMap::bytes_for(traced.photons.size());
    // What the last pass had is gone; what is reported is the greatest of all passes.
    budget.record(structure, 0);
    budget.record("photon_map_build", 0);
    budget.require(structure, peak_bytes);
    const StageTimer timer(stats, "photon_map_build");
    PhotonMap map(std::move(traced.photons), search);
    uint64_t& most = most_bytes_[index_of(kind)];
    most = std::max(most, map.bytes());
    most_build_bytes_ = std::max(most_build_bytes_, peak_bytes - std::min(peak_bytes, map.bytes()));
    budget.record(structure, most);
    budget.record("photon_map_build", most_build_bytes_);
    return map;
}

std::vector<Photon> ProgressivePhotons::trace_pilot(PhotonMapKind kind, uint32_t passes, Stats& stats) const {
    if (!wanted(kind)) return {};
    const StageTimer timer(stats, "photon_tracing");
    std::vector<Photon> photons;
    for (uint32_t pass = 0; pass < passes; ++pass) {
        TracedPhotons traced = tracers_[index_of(kind)]->trace(pilot_seed(), pass, CancelToken{});
        stats.counts.photon_rays += traced.counts.photon_rays;
        photons.insert(photons.end(), traced.photons.begin(), traced.photons.end());
    }
    return photons;
}

uint64_t ProgressivePhotons::expected_photons(PhotonMapKind kind, const ProgressiveParams& params,
                                              const Workload& workload) {
    const bool lights = workload.lights > 0 || workload.environment_size.pixels() > 0;
    const PhotonYield yield = workload.photon_yield.value_or(kExpectedPhotonYield);
    // Narrow glossy lobes show in what was measured alone.
    const bool specular = workload.needs.delta || (workload.photon_yield && yield.caustic.guided > 0);
    if (why_not(kind, params, lights, specular)) return 0;
    return photond::expected_photons(paths(kind, params), yield_of(yield, kind).by(params.projection_maps));
}

uint64_t ProgressivePhotons::estimate_emission_bytes(const ProgressiveParams& params, const Workload& workload) {
    uint64_t guides = 0;
    bool any = false;
    for (const PhotonMapKind kind : kPhotonMapKinds) {
        if (expected_photons(kind, params, workload) == 0) continue;
        any = true;
        if (params.projection_maps) guides += estimate_guide_bytes(kind, workload);
    }
    if (!any) return 0;
    return EmissionSampler::estimate_bytes(workload.lights, workload.environment_size) +
           PhotonTracer::scratch_bytes(workload.threads) + guides;
}

uint64_t ProgressivePhotons::estimate_bytes(const ProgressiveParams& params, const Workload& workload) {
    uint64_t bytes = 0, build = 0;  // of one map at a time
    for (const PhotonMapKind kind : kPhotonMapKinds) {
        const uint64_t photons = expected_photons(kind, params, workload);
        if (photons == 0) continue;
        const uint64_t map =
            photons * sizeof(PhotonPayload) + std::max(KdTree::bytes_for(photons), HashGrid::bytes_for(photons));
        bytes += map;
        build = std::max(build, PhotonMap::bytes_for(photons) - map);
    }
    return bytes + build + estimate_emission_bytes(params, workload);
}

}  // namespace photond
