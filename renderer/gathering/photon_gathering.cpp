#include "renderer/gathering/photon_gathering.h"

#include <cstdio>

#include "renderer/photons/photon_cloud.h"

namespace photond {

namespace {

/// Bytes of a map, and what its building takes beside it for a while.
struct MapBytes {
    MapBytes(uint64_t photons, PhotonSearch::Kind kind)
        : map(photons * sizeof(PhotonPayload) +
              (kind == PhotonSearch::Kind::Nearest ? KdTree::bytes_for(photons) : HashGrid::bytes_for(photons))),
          build(PhotonMap::bytes_for(photons) - map) {}
    uint64_t map, build;
};

uint64_t guide_bytes(const GatheringParams& params, const PhotonPlan& plan, const Workload& workload) {
    if (!params.projection_maps) return 0;
    uint64_t bytes = 0;
    for (const PhotonMapKind kind : {PhotonMapKind::Global, PhotonMapKind::Caustic})
        if ((kind == PhotonMapKind::Global ? plan.global : plan.caustic).wanted())
            bytes += estimate_guide_bytes(kind, workload);
    return bytes;
}

uint64_t split_sampler_bytes(const Splits& splits) {
    return SplitSamplers::bytes_for(splits.light_samples) +
           (splits.gather_rays > 0 ? SplitSamplers::bytes_for(splits.gather_rays) : 0);
}

}  // namespace

uint64_t PhotonGathering::estimate_bytes(const GatheringParams& params, const Workload& workload) {
    const PhotonYield yield = workload.photon_yield.value_or(kExpectedPhotonYield);
    const PhotonPlan plan = plan_of(params, workload);
    uint64_t bytes = PassImage::bytes_for(workload.film_size, workload.layers) +
                     workload.threads * EyePass::bytes_per_thread() +
                     LightSampler::estimate_bytes(workload.lights, workload.environment_size);
    bytes += split_sampler_bytes(params.splits(workload.film_size.pixels()));
    if (plan.global.wanted() || plan.caustic.wanted() || plan.shadow)
        bytes += EmissionSampler::estimate_bytes(workload.lights, workload.environment_size);
    if (plan.global.wanted() || plan.caustic.wanted()) bytes += PhotonTracer::scratch_bytes(workload.threads);
    if (params.boundary == DiscBoundary::Clip) bytes += EdgeTree::estimate_bytes(workload.triangles);
    const uint64_t copies = params.keep_photon_map ? 2 : 1;
    uint64_t build = 0;  // of one map at a time
    if (plan.global.wanted()) {
        const uint64_t stored = expected_photons(params.photons, yield.global.by(params.projection_maps));
        const MapBytes global(stored, params.search_kind());
        bytes += copies * global.map;
        build = global.build;
        if (plan.irradiance_scatterings > 0) bytes += PrecomputedIrradiance::bytes_for(stored);
    }
    if (plan.caustic.wanted()) {
        const MapBytes caustic(
            expected_photons(params.caustic_photons.value_or(params.photons), yield.caustic.by(params.projection_maps)),
            params.search_kind());
        bytes += copies * caustic.map;
        build = std::max(build, caustic.build);
    }
    bytes += build + guide_bytes(params, plan, workload);
    // A light path meets two surfaces one behind the other in furnished rooms, fewer in empty ones.
    if (plan.shadow) bytes += ShadowPhotons::bytes_for(2 * uint64_t{params.photons});
    return bytes;
}

PhotonGathering::PhotonGathering(const RenderContext& context, const GatheringParams& params, Stats& stats)
    : shared_(context, params), params_(params), budget_(context.budget) {
    const Scene& scene = context.scene;
    image_ = PassImage(context.view.film_size, context.view.layers);
    budget_.record("pass_image", PassImage::bytes_for(context.view.film_size, context.view.layers));
    budget_.record("wavefronts", most_threads() * EyePass::bytes_per_thread());
    budget_.record("light_sampler", shared_.lights.bytes());
    budget_.record("split_samplers", split_sampler_bytes(shared_.splits));
    if (shared_.coverage) budget_.record("disc_coverage", shared_.coverage->bytes());

    make_emission(scene, emission_, stats);
    plan_ = PhotonPlan(params_, context.view.film_size.pixels(), emission_.has_value(),
                       has_specular_surface(scene, params_.glossy_threshold));
    note_skipped(stats);
    if (!plan_.global.wanted() && !plan_.caustic.wanted() && !plan_.shadow) {
        emission_.reset();
        return;
    }

    budget_.record("emission_sampler", emission_->bytes());
    const auto guide = [&](PhotonMapKind kind) {
        if (params_.projection_maps)
            guides_.add(kind, scene, *context.intersector, *emission_, params_.glossy_threshold, context.seed, budget_,
                        stats);
    };
    if (plan_.global.wanted()) {
        guide(PhotonMapKind::Global);
        global_tracer_.emplace(scene, *context.intersector, *emission_,
                               tracing(PhotonMapKind::Global, params_.photons, plan_.global.most_scatterings));
    }
    if (plan_.caustic.wanted()) {
        guide(PhotonMapKind::Caustic);
        caustic_tracer_.emplace(scene, *context.intersector, *emission_,
                                tracing(PhotonMapKind::Caustic, params_.caustic_photons.value_or(params_.photons),
                                        plan_.caustic.most_scatterings));
    }
    if (global_tracer_ || caustic_tracer_) budget_.record("photon_tracer", PhotonTracer::scratch_bytes(most_threads()));
}

PhotonTracing PhotonGathering::tracing(PhotonMapKind kind, uint32_t photons, uint32_t most_scatterings) const {
    return {.kind = kind,
            .photons = photons,
            .most_scatterings = most_scatterings,
            .glossy_threshold = params_.glossy_threshold,
            .sampler = params_.sampler,
            .guide = guides_.of(kind)};
}

void PhotonGathering::record(const std::string& structure, uint64_t bytes) {
    uint64_t& most = most_bytes_[structure];
    most = std::max(most, bytes);
    budget_.record(structure, most);
}

void PhotonGathering::note_skipped(Stats& stats) const {
    const uint64_t global = expected_photons(params_.photons, kExpectedPhotonYield.global.unguided);
    if (!plan_.global.wanted())
        stats.skipped.push_back({"global map", plan_.global.why_not, PhotonMap::bytes_for(global)});
    if (!plan_.caustic.wanted())
        stats.skipped.push_back(
            {"caustic map", plan_.caustic.why_not,
             PhotonMap::bytes_for(expected_photons(params_.caustic_photons.value_or(params_.photons),
                                                   kExpectedPhotonYield.caustic.unguided))});
    if (const char* why = plan_.why_not_precomputed(params_))
        stats.skipped.push_back({"precomputed irradiance", why, PrecomputedIrradiance::bytes_for(global)});
    if (!shared_.scene.needs.solid_glass) stats.skipped.push_back({"absorption", "no solid refracts", 0});
}

PhotonMap PhotonGathering::make_map(const std::optional<PhotonTracer>& tracer, const std::string& structure,
                                    uint32_t nearest, uint32_t pass, Stats& stats, const CancelToken& cancel) {
    if (!tracer) return {};
    TracedPhotons traced;
    {
        const StageTimer timer(stats, "photon_tracing");
        traced = tracer->trace(shared_.seed, pass, cancel);
    }
    stats.counts += traced.counts;
    if (cancel.cancelled()) return {};
    const uint64_t peak_bytes = PhotonMap::bytes_for(traced.photons.size());
    // What the last pass had is gone.
    budget_.record(structure, 0);
    budget_.record("photon_map_build", 0);
    budget_.require(structure, peak_bytes);
    const StageTimer timer(stats, "photon_map_build");
    PhotonMap map(std::move(traced.photons), {params_.search_kind(), nearest, shared_.search_radius_m});
    record(structure, map.bytes());
    record("photon_map_build", peak_bytes - std::min(peak_bytes, map.bytes()));
    return map;
}

void PhotonGathering::trace_photons(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    pass_complete_ = false;
    maps_ = PassMaps{};
    maps_.global = make_map(global_tracer_, "global_map", params_.nearest_photons, pass, stats, cancel);
    maps_.caustic = make_map(caustic_tracer_, "caustic_map",
                             params_.caustic_nearest_photons.value_or(params_.nearest_photons), pass, stats, cancel);
    if (cancel.cancelled()) return;
    if (plan_.irradiance_scatterings > 0 && !maps_.global.empty()) {
        const StageTimer timer(stats, "photon_map_build");
        maps_.irradiance.emplace(maps_.global, shared_.estimate, plan_.irradiance_scatterings);
        record("precomputed_irradiance", maps_.irradiance->bytes());
    }
    if (plan_.shadow) {
        const StageTimer timer(stats, "photon_tracing");
        const Scene& scene = shared_.scene;
        maps_.shadow.emplace(scene, shared_.intersector, *emission_, params_.photons,
                             params_.shadow_radius_m(scene.bounds.radius()), shared_.seed, pass, cancel, stats.counts);
        record("shadow_photons", maps_.shadow->bytes());
    }
}

void PhotonGathering::look_from_eye(uint32_t pass, const std::function<RayEndLookups&()>& ends_of_thread,
                                    const std::function<double()>& finish_ends, Stats& stats,
                                    const CancelToken& cancel) {
    const double wall_start = wall_now_seconds();
    const auto split = [&](uint32_t samples) { return SplitSamplers(shared_.sampler, shared_.seed, pass, samples); };
    const PassSamplers samplers{{shared_.sampler, shared_.seed, RandomDomain::Camera, pass},
                                split(shared_.splits.light_samples),
                                split(shared_.splits.gather_rays)};
    const EyePassSetting setting{shared_, maps_, samplers};
    parallel_over_tiles(shared_.view.film_size, EyePass::kTileSide, cancel, [&](const Tile& tile) {
        PerThread& mine = threads_.local();
        mine.eye.trace_tile(setting, tile, ends_of_thread(), image_, mine.counts, mine.seconds, cancel);
    });
    const double finishing = !cancel.cancelled() && finish_ends ? finish_ends() : 0;

    EyeSeconds cpu = take_work(threads_, stats);
    cpu.points += finishing;
    add_interleaved_stages(
        stats, wall_now_seconds() - wall_start,
        {{"g_buffer", cpu.camera}, {"direct", cpu.direct}, {"indirect", cpu.indirect}, {"gather", cpu.points}});
    pass_complete_ = !cancel.cancelled();
}

PassImage* PhotonGathering::end_pass() {
    if (!pass_complete_) return nullptr;
    if (!params_.keep_photon_map) return &image_;
    kept_global_ = std::move(maps_.global);
    kept_caustic_ = std::move(maps_.caustic);
    record("kept_photon_maps", kept_global_.bytes() + kept_caustic_.bytes());
    return &image_;
}

std::vector<MethodArtefact> PhotonGathering::artefacts() const {
    if (!params_.keep_photon_map) return {};
    return {{kPhotonMapFile, "model/gltf-binary", [this](const std::filesystem::path& path) {
                 write_photon_cloud(kept_global_, kept_caustic_, shared_.scene.origin, path);
             }}};
}

Workload workload_of(const RenderContext& context) {
    const Scene& scene = context.scene;
    return {.film_size = context.view.film_size,
            .layers = context.view.layers,
            .threads = static_cast<unsigned>(most_threads()),
            .lights = scene.triangle_lights.size() + scene.punctual_lights.size(),
            .environment_size = scene.environment ? scene.environment->map.size : Size2{},
            .triangles = scene.triangle_count,
            .needs = scene.needs,
            .photon_yield = {}};
}

std::vector<KnownLimit> limits_of_density_estimates() {
    const std::vector<ParamSetting> whole_discs = {{"boundary", "none"}};
    return {{whole_discs, "thin wall", "a disc of the density estimate does not see a wall thinner than its radius"},
            {whole_discs, "corner", "lookups of the density estimate reach past the edge"},
            {{}, "corner", "the density estimate smears light within its radius"},
            {{}, "facing", "the density estimate loses light within its radius of edges"},
            {{}, "caustic", "the density estimate smears light within its radius"}};
}

uint64_t photon_map_file_bytes(uint64_t map_bytes) {
    constexpr uint64_t kPhotons = 1'000'000;
    const double photons =
        static_cast<double>(map_bytes) * kPhotons / static_cast<double>(PhotonMap::bytes_for(kPhotons));
    return photon_cloud_bytes(static_cast<uint64_t>(photons));
}

}  // namespace photond
