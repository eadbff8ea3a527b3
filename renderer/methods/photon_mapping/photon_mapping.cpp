#include "renderer/methods/photon_mapping/photon_mapping.h"

#include <cstdio>

#include "renderer/core/thread_local.h"
#include "renderer/methods/photon_mapping/eye_pass.h"
#include "renderer/methods/photon_mapping/photon_plan.h"
#include "renderer/photons/photon_cloud.h"
#include "renderer/photons/photon_tracer.h"
#include "renderer/photons/projection_map.h"

namespace photond {

namespace {

uint64_t expected(uint32_t photons, double stored) { return static_cast<uint64_t>(stored * photons) + 1; }

/// Bytes of a map, and what its building takes beside it for a while.
struct MapBytes {
    MapBytes(uint64_t photons, PhotonSearch::Kind kind)
        : map(photons * sizeof(PhotonPayload) +
              (kind == PhotonSearch::Kind::Nearest ? KdTree::bytes_for(photons) : HashGrid::bytes_for(photons))),
          build(PhotonMap::bytes_for(photons) - map) {}
    uint64_t map, build;
};

uint64_t split_sampler_bytes(const Splits& splits) {
    return SplitSamplers::bytes_for(splits.light_samples) +
           (splits.gather_rays > 0 ? SplitSamplers::bytes_for(splits.gather_rays) : 0);
}

std::string projection_text(const ProjectionMap& map) {
    char text[160];
    std::snprintf(text, sizeof text, "%.1f %% of the photons meet specular surfaces unguided, %.1f %% would guided",
                  100 * map.specular_share(), 100 * map.guided_share());
    return text;
}

}  // namespace

struct PhotonMapping::State {
    struct PerThread {
        EyePass eye;
        Counts counts;
        EyeSeconds seconds;
    };

    State(const RenderContext& context, const PhotonMappingParams& params)
        : shared(context, params), budget(context.budget), image(context.view.film_size, context.view.layers) {}

    PhotonTracing tracing(PhotonMapKind kind, uint32_t photons, uint32_t most_scatterings) const {
        return {.kind = kind,
                .photons = photons,
                .most_scatterings = most_scatterings,
                .glossy_threshold = shared.params.glossy_threshold,
                .sampler = shared.params.sampler,
                .guide = kind == PhotonMapKind::Caustic && projection ? &*projection : nullptr};
    }
    PhotonSearch search(uint32_t nearest) const { return {shared.params.search, nearest, shared.search_radius_m}; }
    /// A structure of this pass: what is reported is the greatest of all passes.
    void record(const std::string& structure, uint64_t bytes) {
        uint64_t& most = most_bytes[structure];
        most = std::max(most, bytes);
        budget.record(structure, most);
    }

    PhotonMappingScene shared;
    MemoryBudget& budget;
    PhotonPlan plan{{}, false, false};
    std::optional<EmissionSampler> emission;
    std::optional<ProjectionMap> projection;
    std::optional<PhotonTracer> global_tracer, caustic_tracer;
    ThreadLocal<PerThread> threads;
    std::map<std::string, uint64_t> most_bytes;

    PassMaps maps;  // of the pass
    PassImage image;
    bool pass_complete = false;  // image holds a whole pass
    PhotonMap kept_global, kept_caustic;
};

PhotonMapping::PhotonMapping(const PhotonMappingParams& params) : params_(params) {}
PhotonMapping::~PhotonMapping() = default;

uint64_t PhotonMapping::estimate_bytes(const PhotonMappingParams& params, const Workload& workload) {
    const bool lights = workload.lights > 0 || workload.environment_size.pixels() > 0;
    const PhotonYield yield = workload.photon_yield.value_or(kExpectedYield);
    // Narrow glossy lobes show in what was measured alone.
    const bool specular = workload.needs.delta || (workload.photon_yield && yield.caustic > 0);
    const PhotonPlan plan(params, lights, specular);
    uint64_t bytes = PassImage::bytes_for(workload.film_size, workload.layers) +
                     workload.threads * EyePass::bytes_per_thread() +
                     LightSampler::estimate_bytes(workload.lights, workload.environment_size);
    bytes += split_sampler_bytes(params.splits(workload.film_size.pixels()));
    if (plan.global.wanted() || plan.caustic.wanted() || plan.shadow)
        bytes += EmissionSampler::estimate_bytes(workload.lights, workload.environment_size);
    if (plan.global.wanted() || plan.caustic.wanted()) bytes += PhotonTracer::scratch_bytes(workload.threads);
    if (params.boundary == DiscBoundary::Clip) bytes += EdgeCells::estimate_bytes(workload.triangles);
    const uint64_t copies = params.keep_photon_map ? 2 : 1;
    uint64_t build = 0;  // of one map at a time
    if (plan.global.wanted()) {
        const uint64_t stored = expected(params.photons, yield.global);
        const MapBytes global(stored, params.search);
        bytes += copies * global.map;
        build = global.build;
        if (plan.irradiance_scatterings > 0) bytes += PrecomputedIrradiance::bytes_for(stored);
    }
    if (plan.caustic.wanted()) {
        const MapBytes caustic(expected(params.caustic_photons.value_or(params.photons),
                                        params.projection_maps ? yield.caustic : yield.caustic_unguided),
                               params.search);
        bytes += copies * caustic.map;
        build = std::max(build, caustic.build);
        if (params.projection_maps) bytes += ProjectionMap::estimate_bytes(workload.lights);
    }
    bytes += build;
    // A light path meets two surfaces one behind the other in furnished rooms, fewer in empty ones.
    if (plan.shadow) bytes += ShadowPhotons::bytes_for(2 * uint64_t{params.photons});
    return bytes;
}

void PhotonMapping::begin(const RenderContext& context, Stats& stats) {
    const Scene& scene = context.scene;
    const uint64_t lights = scene.triangle_lights.size() + scene.punctual_lights.size();
    const Size2 environment = scene.environment ? scene.environment->map.size : Size2{};
    const Workload workload{context.view.film_size, context.view.layers, unsigned(most_threads()), lights, environment,
                            scene.triangle_count,   scene.needs};
    context.budget.require("photon_mapping", estimate_bytes(params_, workload));

    state_ = std::make_unique<State>(context, params_);
    State& state = *state_;
    MemoryBudget& budget = context.budget;
    budget.record("pass_image", PassImage::bytes_for(context.view.film_size, context.view.layers));
    budget.record("wavefronts", most_threads() * EyePass::bytes_per_thread());
    budget.record("light_sampler", state.shared.lights.bytes());
    budget.record("split_samplers", split_sampler_bytes(state_->shared.splits));
    if (state.shared.coverage) budget.record("disc_coverage", state.shared.coverage->bytes());

    if (!state.shared.lights.empty()) {
        const StageTimer timer(stats, "photon_emission");
        state.emission.emplace(scene);
        if (!(state.emission->total_power_w() > 0)) state.emission.reset();
    }
    state.plan = PhotonPlan(params_, state.emission.has_value(), has_specular_surface(scene, params_.glossy_threshold));
    const PhotonPlan& plan = state.plan;
    const uint32_t caustic_photons = params_.caustic_photons.value_or(params_.photons);
    if (!plan.global.wanted())
        stats.skipped.push_back({"global map", plan.global.why_not,
                                 PhotonMap::bytes_for(expected(params_.photons, kExpectedYield.global))});
    if (!plan.caustic.wanted())
        stats.skipped.push_back({"caustic map", plan.caustic.why_not,
                                 PhotonMap::bytes_for(expected(caustic_photons, kExpectedYield.caustic))});
    if (params_.precompute_irradiance && plan.irradiance_scatterings == 0)
        stats.skipped.push_back(
            {"precomputed irradiance",
             params_.gather == Gather::Direct ? "it is for the ends of gather rays" : plan.global.why_not,
             PrecomputedIrradiance::bytes_for(expected(params_.photons, kExpectedYield.global))});
    if (!scene.needs.solid_glass) stats.skipped.push_back({"absorption", "no solid refracts", 0});
    if (!plan.global.wanted() && !plan.caustic.wanted() && !plan.shadow) {
        state.emission.reset();
        return;
    }

    budget.record("emission_sampler", state.emission->bytes());
    if (plan.global.wanted())
        state.global_tracer.emplace(
            scene, *context.intersector, *state.emission,
            state.tracing(PhotonMapKind::Global, params_.photons, plan.global.most_scatterings));
    if (plan.caustic.wanted()) {
        if (params_.projection_maps) build_projection_map(context, stats);
        state.caustic_tracer.emplace(
            scene, *context.intersector, *state.emission,
            state.tracing(PhotonMapKind::Caustic, caustic_photons, plan.caustic.most_scatterings));
    }
    if (state.global_tracer || state.caustic_tracer)
        budget.record("photon_tracer", PhotonTracer::scratch_bytes(most_threads()));
}

void PhotonMapping::build_projection_map(const RenderContext& context, Stats& stats) {
    const StageTimer timer(stats, "photon_emission");
    State& state = *state_;
    state.projection.emplace(context.scene, *context.intersector, *state.emission, params_.glossy_threshold,
                             context.seed);
    stats.counts.photon_rays += state.projection->pilot_rays();
    // What its building took beside it has been given back, but it was there.
    const Scene& scene = context.scene;
    const uint64_t most = ProjectionMap::estimate_bytes(scene.triangle_lights.size() + scene.punctual_lights.size());
    const uint64_t kept = state.projection->helps() ? state.projection->bytes() : 0;
    context.budget.record("projection_map_build", most - std::min(most, kept));
    if (kept > 0) {
        context.budget.record("projection_map", kept);
        return;
    }
    stats.skipped.push_back({"projection map", projection_text(*state.projection), state.projection->bytes()});
    state.projection.reset();
}

void PhotonMapping::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    state_->pass_complete = false;
    state_->maps = PassMaps{};
    trace_photons(pass, stats, cancel);
    if (cancel.cancelled()) return;
    look_from_eye(pass, stats, cancel);
    state_->pass_complete = !cancel.cancelled();
}

/// Pass 1: the maps. Cancelled: they are empty.
void PhotonMapping::trace_photons(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    const auto make_map = [&](const std::optional<PhotonTracer>& tracer, const std::string& structure,
                              uint32_t nearest) -> PhotonMap {
        if (!tracer) return {};
        TracedPhotons traced;
        {
            const StageTimer timer(stats, "photon_tracing");
            traced = tracer->trace(state.shared.seed, pass, cancel);
        }
        stats.counts += traced.counts;
        if (cancel.cancelled()) return {};
        const uint64_t peak_bytes = PhotonMap::bytes_for(traced.photons.size());
        // What the last pass had is gone.
        state.budget.record(structure, 0);
        state.budget.record("photon_map_build", 0);
        state.budget.require(structure, peak_bytes);
        const StageTimer timer(stats, "photon_map_build");
        PhotonMap map(std::move(traced.photons), state.search(nearest));
        state.record(structure, map.bytes());
        state.record("photon_map_build", peak_bytes - std::min(peak_bytes, map.bytes()));
        return map;
    };
    PassMaps& maps = state.maps;
    maps.global = make_map(state.global_tracer, "global_map", params_.nearest_photons);
    maps.caustic = make_map(state.caustic_tracer, "caustic_map",
                            params_.caustic_nearest_photons.value_or(params_.nearest_photons));
    if (cancel.cancelled()) return;
    if (state.plan.irradiance_scatterings > 0 && !maps.global.empty()) {
        const StageTimer timer(stats, "photon_map_build");
        maps.irradiance.emplace(maps.global, state.shared.estimate, state.plan.irradiance_scatterings);
        state.record("precomputed_irradiance", maps.irradiance->bytes());
    }
    if (state.plan.shadow) {
        const StageTimer timer(stats, "photon_tracing");
        const Scene& scene = state.shared.scene;
        maps.shadow.emplace(scene, state.shared.intersector, *state.emission, params_.photons,
                            params_.shadow_radius_m(scene.bounds.radius()), state.shared.seed, pass, cancel,
                            stats.counts);
        state.record("shadow_photons", maps.shadow->bytes());
    }
}

/// Pass 2: the image.
void PhotonMapping::look_from_eye(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    const PhotonMappingScene& shared = state.shared;
    const double wall_start = wall_now_seconds();
    const auto split = [&](uint32_t samples) { return SplitSamplers(shared.sampler, shared.seed, pass, samples); };
    const PassSamplers samplers{{shared.sampler, shared.seed, RandomDomain::Camera, pass},
                                split(shared.splits.light_samples),
                                split(shared.splits.gather_rays)};
    parallel_over_tiles(shared.view.film_size, EyePass::kTileSide, cancel, [&](const Tile& tile) {
        State::PerThread& mine = state.threads.local();
        mine.eye.trace_tile(shared, state.maps, samplers, tile, state.image, mine.counts, mine.seconds, cancel);
    });

    const EyeSeconds cpu = take_work(state.threads, stats);
    add_interleaved_stages(
        stats, wall_now_seconds() - wall_start,
        {{"g_buffer", cpu.camera}, {"direct", cpu.direct}, {"indirect", cpu.indirect}, {"gather", cpu.points}});
}

void PhotonMapping::resolve(Film& film) {
    State& state = *state_;
    if (!state.pass_complete) return;
    film.add_pass(state.image);
    if (!params_.keep_photon_map) return;
    state.kept_global = std::move(state.maps.global);
    state.kept_caustic = std::move(state.maps.caustic);
    state.record("kept_photon_maps", state.kept_global.bytes() + state.kept_caustic.bytes());
}

std::vector<MethodArtefact> PhotonMapping::artefacts() const {
    if (!params_.keep_photon_map || !state_) return {};
    return {{kArtefact, "model/gltf-binary", [this](const std::filesystem::path& path) {
                 write_photon_cloud(state_->kept_global, state_->kept_caustic, state_->shared.scene.origin, path);
             }}};
}

}  // namespace photond
