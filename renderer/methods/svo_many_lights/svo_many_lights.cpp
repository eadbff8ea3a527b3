#include "renderer/methods/svo_many_lights/svo_many_lights.h"

#include <map>

#include "renderer/core/rng.h"
#include "renderer/core/thread_local.h"
#include "renderer/gbuffer/geometry_filter.h"
#include "renderer/gbuffer/light_depth_guide.h"
#include "renderer/many_lights/camera_importance.h"
#include "renderer/many_lights/clamp_repayment.h"
#include "renderer/many_lights/vpl_choice.h"
#include "renderer/many_lights/vpl_shadow_maps.h"
#include "renderer/many_lights/vpl_tracer.h"
#include "renderer/methods/svo_many_lights/svo_layers.h"
#include "renderer/methods/svo_many_lights/svo_memory.h"
#include "renderer/methods/svo_many_lights/svo_settings.h"
#include "renderer/voxels/kept_voxels.h"
#include "renderer/voxels/voxel_intersector.h"

namespace photond {

namespace {

constexpr uint32_t kPointsAtOnce = SplitLayout::kGroup;
constexpr uint64_t kRotationStream = 0;  // of RandomDomain::Splats in a pass

}  // namespace

struct SvoManyLights::State {
    struct PerThread {
        SpecularWalk walk{GBuffer::kTileSide};
        GBufferSink sink;
        VplLighting lighting;
        VplChooser::Scratch choice;
        ClampRepayment repayment;
        std::vector<ClampedPoint> clamped;
        std::vector<uint32_t> places;  // of those in the G-buffer
        std::vector<Rgb> repaid, narrow;
        Neighbours neighbours;
        Counts counts;
        EyeSeconds seconds;
        double lit_seconds = 0, gathered_seconds = 0, repaid_seconds = 0;
    };

    State(const RenderContext& context, const SvoManyLightsParams& params)
        : eye(context, params.sampler, params.max_scatterings()),
          budget(context.budget),
          buffer(context.view.film_size, params.split_side(), params.max_scatterings()),
          sums(buffer.layout().points()),
          image(context.view.film_size, context.view.layers) {}

    /// A structure of this pass: what is reported is the greatest of all passes.
    void record(const std::string& structure, uint64_t bytes) {
        uint64_t& most = most_bytes[structure];
        most = std::max(most, bytes);
        budget.record(structure, most);
    }
    void take_counts(Stats& stats) {
        for (PerThread& thread : threads) stats.counts += std::exchange(thread.counts, {});
    }

    const EyeScene eye;
    MemoryBudget& budget;
    std::optional<EmissionSampler> emission;
    std::optional<SparseVoxelOctree> tree;
    std::optional<VoxelIntersector> voxels;
    std::optional<VplTracer> tracer;  // none: nothing is lit
    std::optional<VplShadowMaps> maps;
    std::optional<LightDepthMaps> light_maps;  // none: direct light by rays alone
    std::optional<CausticPhotons> caustics;    // none: what narrow lobes send is path traced
    std::unique_ptr<VplChooser> chooser;       // null: interleaved
    float clamp_sq_m2 = 0;                     // B
    std::optional<PathPilot> pilot;            // of placements that select paths
    ThreadLocal<PerThread> threads;
    std::map<std::string, uint64_t> most_bytes;

    GBuffer buffer;
    VplSet set;  // of the pass
    VplSubsets subsets;
    CausticMap caustic_map;                           // of the pass
    std::vector<Rgb> sums, repaid, narrow, filtered;  // by point
    PassImage image;
    bool pass_complete = false;  // image holds a whole pass
};

SvoManyLights::SvoManyLights(const SvoManyLightsParams& params)
    : FollowsFrames(params.incremental, params.vpls), params_(params) {}
SvoManyLights::~SvoManyLights() = default;

void SvoManyLights::begin(const RenderContext& context, Stats& stats) {
    const Scene& scene = context.scene;
    const Workload workload{context.view.film_size,
                            context.view.layers,
                            unsigned(most_threads()),
                            scene.triangle_lights.size() + scene.punctual_lights.size(),
                            scene.environment ? scene.environment->map.size : Size2{},
                            scene.triangle_count,
                            scene.needs,
                            {}};
    context.budget.require(kName, estimate_bytes(params_, workload));

    state_ = std::make_unique<State>(context, params_);
    State& state = *state_;
    MemoryBudget& budget = context.budget;
    budget.record("pass_image", PassImage::bytes_for(context.view.film_size, context.view.layers));
    budget.record("wavefronts", most_threads() * SpecularWalk::bytes_per_thread(GBuffer::kTileSide));
    budget.record("light_sampler", state.eye.lights.bytes());

    if (has_light_maps(params_, scene.needs)) {
        budget.require("light_depth_maps", LightDepthMaps::bytes_for(scene, params_.direct_resolution));
        state.light_maps.emplace(scene, *context.intersector, params_.direct_resolution, params_.pcf, stats);
        budget.record("light_depth_maps", state.light_maps->bytes());
    }

    const char* nothing = params_.bounces == 0       ? "bounces is 0"
                          : state.eye.lights.empty() ? "the scene has no light"
                                                     : nullptr;
    if (!nothing) {
        state.emission = emission_of(scene);
        if (!state.emission) nothing = "the scene has no light";
    }
    if (nothing) {
        stats.skipped.push_back({"virtual point lights", nothing, light_bytes(params_, scene.needs)});
        return;
    }
    budget.record("emission_sampler", state.emission->bytes());
    if (params_.needs_voxels(context.view.layers)) {
        state.tree.emplace(make_octree(context.kept_voxels, scene,
                                       make_voxel_grid(scene.bounds, params_.voxel_resolution), traces_voxels(params_),
                                       budget, stats));
        stats.counts.voxels += state.tree->voxel_count();
        if (traces_voxels(params_)) state.voxels.emplace(scene, *state.tree);
    } else {
        stats.skipped.push_back(
            {"sparse voxel octree", "neither visibility, bounces nor layers ask for it", voxel_tree_bytes(params_)});
    }
    const Intersector& further = state.voxels ? static_cast<const Intersector&>(*state.voxels) : *context.intersector;
    state.tracer.emplace(scene, *context.intersector, further, *state.emission, tracing_of(params_));
    budget.record("vpl_tracer", VplTracer::scratch_bytes(tracing_of(params_), most_threads(), workload.lights));
    if (params_.vpl_choice == VplChoice::Lightcut)
        state.chooser = std::make_unique<LightcutVpls>(params_.cut_size);
    else if (params_.vpl_choice == VplChoice::Resampled)
        state.chooser = std::make_unique<ResampledVpls>(params_.resampled_vpls);
    if (params_.visibility == VplVisibility::ShadowMaps) state.maps.emplace(params_.shadow_resolution);
    const auto lit_area_m2 = [&] { return static_cast<float>(state.tracer->lit_area_m2(context.seed)); };
    state.clamp_sq_m2 = params_.clamp_m2 ? *params_.clamp_m2 : default_clamp_sq_m2(lit_area_m2(), params_.vpls);
    if (frames_.on()) frames_.renew(*state.tracer, *state.emission, context, stats);
    if (selects_paths(params_.placement))
        state.pilot = find_path_pilot(
            params_.placement, *state.tracer,
            CameraImportance(scene, *context.intersector, context.view, state.clamp_sq_m2, context.seed),
            *context.intersector, params_.vpls, context.seed, stats);
    make_caustics(context, stats);
    if (!scene.needs.solid_glass) stats.skipped.push_back({"absorption", "no solid refracts", 0});
}

/// What sends caustic photons, where there are any.
void SvoManyLights::make_caustics(const RenderContext& context, Stats& stats) {
    const Scene& scene = context.scene;
    State& state = *state_;
    const CausticSettings settings = caustics_of(params_);
    if (const char* why = why_no_caustics(params_, has_specular_surface(scene, settings.glossy_threshold))) {
        stats.skipped.push_back(
            {"caustic map", why,
             params_.caustic_photons > 0 ? CausticPhotons::map_bytes(settings, kExpectedCausticYield) : 0});
        return;
    }
    const uint64_t most =
        CausticPhotons::estimate_bytes(scene.triangle_lights.size() + scene.punctual_lights.size(), most_threads());
    context.budget.require("caustic_photons", most);
    state.caustics.emplace(scene, *context.intersector, *state.emission, settings, context.seed, stats);
    // What building it took beside it has been given back, but it was there.
    context.budget.record("caustic_photons", most);
}

void SvoManyLights::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    state_->pass_complete = false;
    look_from_eye(pass, stats, cancel);
    if (cancel.cancelled()) return;
    make_lights(pass, stats, cancel);
    if (cancel.cancelled()) return;
    send_caustic_photons(pass, stats, cancel);
    if (cancel.cancelled()) return;
    light_points(pass, stats, cancel);
    if (cancel.cancelled()) return;
    merge(stats);
    state_->pass_complete = true;
}

/// Direct light and the G-buffer, split as it is written.
void SvoManyLights::look_from_eye(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    const double wall_start = wall_now_seconds();
    const PassSampler sampler(state.eye.sampler, state.eye.seed, RandomDomain::Camera, pass);
    std::optional<LightDepthGuide> guide;  // which no thread changes
    if (state.light_maps) guide.emplace(*state.light_maps, sampler, pass);
    const WalkSettings settings{.glossy_threshold = params_.glossy_threshold, .guide = guide ? &*guide : nullptr};
    parallel_over_tiles(state.eye.view.film_size, GBuffer::kTileSide, cancel, [&](const Tile& tile) {
        State::PerThread& mine = state.threads.local();
        mine.sink.start(tile, mine.walk, sampler, state.buffer, state.eye.view.camera);
        mine.walk.trace_tile(state.eye, settings, {sampler, std::span(&sampler, 1)}, tile, state.image, mine.counts,
                             mine.seconds, cancel, mine.sink);
        mine.sink.finish();
    });
    if (cancel.cancelled()) return;
    state.record("g_buffer", state.buffer.bytes());
    const EyeSeconds cpu = take_work(state.threads, stats);
    add_interleaved_stages(
        stats, wall_now_seconds() - wall_start,
        {{"g_buffer", cpu.camera}, {"g_buffer_split", cpu.points}, {"direct", cpu.direct + cpu.indirect}});
}

TracedReflections SvoManyLights::trace_lights(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    const State& state = *state_;
    if (frames_.on()) return state.tracer->trace(frames_.seed(), frames_.paths(), stats, cancel);
    if (params_.placement == VplPlacement::Flux) return state.tracer->trace(state.eye.seed, pass, {}, stats, cancel);
    const CameraImportance seen(state.buffer, state.tree ? &*state.tree : nullptr, state.clamp_sq_m2, state.eye.seed,
                                pass);
    if (!state.pilot) return state.tracer->trace(state.eye.seed, pass, seen, stats, cancel);
    return trace_by_worth(params_.placement, *state.pilot, *state.tracer, seen, state.eye.intersector, params_.vpls,
                          state.eye.seed, pass, stats, cancel);
}

void SvoManyLights::make_lights(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    state.set.vpls.clear();
    if (!state.tracer) return;
    const TracedReflections photons = trace_lights(pass, stats, cancel);
    if (cancel.cancelled()) return;
    stats.counts += photons.counts;
    {
        const StageTimer timer(stats, "vpl_generation");
        state.set.assign(state.eye.scene, photons, params_.connect_threshold);
        RandomStream random(state.eye.seed, RandomDomain::Splats, pass, kRotationStream);
        if (state.chooser)
            state.chooser->assign(state.set.vpls);
        else
            state.subsets.assign(state.set, state.buffer.layout().tiles(), random.next_bits());
    }
    stats.counts.vpls += state.set.vpls.size();
    if (state.maps) {
        state.maps->build(state.set.vpls, state.eye.scene, state.eye.intersector, stats);
        state.record("vpl_shadow_maps", state.maps->bytes());
    }
    state.record("vpls", state.set.bytes() + state.subsets.bytes() + (state.chooser ? state.chooser->bytes() : 0) +
                             photons.photons.capacity() * sizeof(ReflectedPhoton) +
                             photons.surfaces.capacity() * sizeof(ReflectingSurface));
}

void SvoManyLights::send_caustic_photons(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    if (!state.caustics) return;
    state.caustic_map = {};
    state.caustic_map = state.caustics->trace(pass, stats, cancel);
    state.record("caustic_map", PhotonMap::bytes_for(state.caustic_map.map.size()));
}

/// What the lights bring to the points, and what the clamp takes.
void SvoManyLights::light_points(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    state.sums.assign(state.sums.size(), Rgb(0));
    state.repaid.assign(repays() ? state.sums.size() : 0, Rgb(0));
    state.narrow.assign(asks_narrow_lobes(params_, state.eye.scene.needs) ? state.sums.size() : 0, Rgb(0));
    if (!state.tracer) return;
    const double wall_start = wall_now_seconds();
    const VplPass lighting{.eye = state.eye,
                           .set = state.set,
                           .subsets = state.subsets,
                           .visibility = params_.visibility,
                           .tree = state.tree ? &*state.tree : nullptr,
                           .maps = state.maps ? &*state.maps : nullptr,
                           .clamp_sq_m2 = state.clamp_sq_m2,
                           .roulette = params_.roulette,
                           .seed = state.eye.seed,
                           .pass = pass,
                           .voxel_reach_m = voxel_reach_m(params_, state.eye.scene)};
    const PassSampler sampler(state.eye.sampler, state.eye.seed, RandomDomain::Splats, pass);
    const RepaymentScene repayment{state.eye, params_.connect_threshold, state.caustics ? &state.caustic_map : nullptr};
    const uint32_t points = state.buffer.layout().points();
    parallel_for(points / kPointsAtOnce, 1, [&](size_t group) {
        if (cancel.cancelled()) return;
        State::PerThread& mine = state.threads.local();
        const auto first = static_cast<uint32_t>(group) * kPointsAtOnce, end = first + kPointsAtOnce;
        const auto of_group = [&](std::vector<Rgb>& values) { return std::span(values).subspan(first, kPointsAtOnce); };
        ThreadLaps laps;
        if (state.chooser)
            light_by_choice(*state.chooser, lighting, state.buffer, first, end, of_group(state.sums), mine.lighting,
                            mine.choice, mine.counts);
        else
            mine.lighting.light(lighting, state.buffer, first, end, of_group(state.sums), mine.counts);
        laps.lap(mine.lit_seconds);
        if (state.caustics) gather_caustics(first, end, mine.neighbours);
        laps.lap(mine.gathered_seconds);
        if (!repays() && !asks_narrow_lobes(params_, state.eye.scene.needs)) return;
        mine.clamped.clear();
        mine.places.clear();
        for (uint32_t i = first; i < end; ++i) {
            const gpu::GBufferPoint& point = state.buffer.points()[i];
            if (point.kind == 0) continue;
            const bool general = (point.kind & GBUFFER_GENERAL) != 0;
            mine.clamped.push_back({point.position, point.geometric_normal, point.normal,
                                    general ? &state.buffer.general(i) : nullptr, point.pixel,
                                    point.kind & GBUFFER_SCATTERINGS});
            mine.places.push_back(i);
        }
        mine.repaid.assign(repays() ? mine.clamped.size() : 0, Rgb(0));
        mine.narrow.assign(asks_narrow_lobes(params_, state.eye.scene.needs) ? mine.clamped.size() : 0, Rgb(0));
        mine.repayment.repay(repayment, sampler, mine.clamped, state.clamp_sq_m2,
                             {.clamped = mine.repaid, .narrow = mine.narrow}, mine.counts);
        for (size_t i = 0; i < mine.places.size(); ++i) {
            if (!mine.repaid.empty()) state.repaid[mine.places[i]] = mine.repaid[i];
            if (!mine.narrow.empty()) state.narrow[mine.places[i]] += mine.narrow[i];
        }
        laps.lap(mine.repaid_seconds);
    });
    double lit_seconds = 0, gathered_seconds = 0, repaid_seconds = 0;
    for (State::PerThread& thread : state.threads) {
        lit_seconds += std::exchange(thread.lit_seconds, 0);
        gathered_seconds += std::exchange(thread.gathered_seconds, 0);
        repaid_seconds += std::exchange(thread.repaid_seconds, 0);
    }
    state.take_counts(stats);
    add_interleaved_stages(stats, wall_now_seconds() - wall_start,
                           {{"indirect", lit_seconds}, {"gather", gathered_seconds}, {"repay", repaid_seconds}});
}

/// Caustics at the points [first, end).
void SvoManyLights::gather_caustics(uint32_t first, uint32_t end, Neighbours& scratch) {
    State& state = *state_;
    for (uint32_t i = first; i < end; ++i) {
        const gpu::GBufferPoint& point = state.buffer.points()[i];
        const uint32_t most = point.kind & GBUFFER_SCATTERINGS;
        if (point.kind == 0) continue;
        if ((point.kind & GBUFFER_GENERAL) != 0) {
            const VisiblePoint& general = state.buffer.general(i);
            state.narrow[i] = state.caustic_map.radiance(general.surface, general.rough, general.wo, most, scratch);
        } else {
            state.narrow[i] =
                state.caustic_map.irradiance(point.position, point.geometric_normal, point.normal, most, scratch);
        }
    }
}

/// From the split buffer into the image.
void SvoManyLights::merge(Stats& stats) {
    State& state = *state_;
    const SplitLayout& layout = state.buffer.layout();
    PassImage& image = state.image;
    if (image.layers.has(Layer::SplitIndirect) || image.layers.has(Layer::SplitNormal)) {
        for (uint32_t pixel = 0; pixel < image.size.pixels(); ++pixel) {
            const uint32_t point = layout.point_shown_at(pixel % image.size.width, pixel / image.size.width);
            if (image.layers.has(Layer::SplitIndirect)) image.of<Layer::SplitIndirect>()[pixel] = state.sums[point];
            if (image.layers.has(Layer::SplitNormal))
                image.of<Layer::SplitNormal>()[pixel] = state.buffer.points()[point].normal;
        }
    }
    if (image.layers.has(Layer::Voxels) && state.tree)
        show_voxels(state.tree->view(), state.eye, image.of<Layer::Voxels>());
    if (image.layers.has(Layer::Vpls)) show_vpls(state.set.vpls, state.eye, state.buffer, image.of<Layer::Vpls>());
    for (const std::vector<Rgb>* more : {params_.repay ? &state.repaid : nullptr, &state.narrow})
        if (more && !more->empty())
            for (size_t i = 0; i < more->size(); ++i) state.sums[i] += (*more)[i];
    std::span<const Rgb> light = state.sums;
    if (params_.filter > 1) {
        const StageTimer timer(stats, "filter");
        state.filtered.resize(state.sums.size());
        filter_geometry_aware(layout, state.buffer.points(), state.sums,
                              {params_.filter, params_.filter_normal, params_.filter_distance}, state.filtered);
        light = state.filtered;
    }
    const StageTimer timer(stats, "merge");
    parallel_for(layout.points(), 4096, [&](size_t i) {
        const gpu::GBufferPoint& point = state.buffer.points()[i];
        if (point.kind == 0) return;
        image.of<Layer::Indirect>()[point.pixel] += point.weight * light[i];
        if (image.layers.has(Layer::Clamped) && !state.repaid.empty())
            image.of<Layer::Clamped>()[point.pixel] = point.weight * state.repaid[i];
    });
}

/// Whether short rays find what the clamp takes: it is added, or shown.
bool SvoManyLights::repays() const {
    return state_->clamp_sq_m2 > 0 && (params_.repay || state_->image.layers.has(Layer::Clamped));
}

PassImage* SvoManyLights::end_pass() { return state_->pass_complete ? &state_->image : nullptr; }

}  // namespace photond
