#include "renderer/bidirectional/bidirectional_method.h"

#include "renderer/bidirectional/eye_paths.h"
#include "renderer/bidirectional/technique_pilot.h"
#include "renderer/core/thread_local.h"
#include "renderer/frame/left_out.h"
#include "renderer/photons/pilot_radius.h"
#include "renderer/photons/surface_edges.h"
#include "renderer/progressive/disc_radii.h"

namespace photond {

namespace {

constexpr uint64_t kPilotSeed = reference_seed(0xb1d1);
constexpr uint32_t kPilotPaths = 1u << 15;
constexpr uint32_t kPilotNearest = 8;  // vertices among which a pilot's density is measured
// Of the power is where they are denser than the first radius asks for.
constexpr double kBrightShare = 0.5, kBrightCausticShare = 0.25;
/// Vertices of a light path, while nobody has counted them.
constexpr double kExpectedVertices = 3;
/// Of merging near edges, where there are delta lobes: PassTechniques::edge_share.
constexpr float kEdgeShare = 1e-3f;
/// Passes differ from the pilot; what they keep is let grow by this.
constexpr double kMargin = 1.1;

/// Of the cache, a vertex. `merging`: nullptr where nothing merges.
uint64_t bytes_of_vertex(const MergingParams* merging) {
    const bool places = merging != nullptr && merging->weights == MergeWeights::CorrelationAware;
    return sizeof(LightVertex) + (places ? sizeof(LightPlace) : 0);
}
uint64_t bytes_of_path(double vertices, const MergingParams* merging) {
    const double grid =
        merging != nullptr ? static_cast<double>(HashGrid::bytes_for(1u << 20)) / (1u << 20) + sizeof(uint32_t) : 0;
    // As they are traced, and put one behind the other.
    return static_cast<uint64_t>(vertices *
                                 (2.0 * static_cast<double>(bytes_of_vertex(merging) + sizeof(LightSplat)) + grid));
}

/// Light paths a pixel that the cache has room for.
float most_light_paths(const BidirectionalParams& params, Size2 size, double vertices_per_path) {
    const double room =
        static_cast<double>(params.light_cache_mib) * (1 << 20) /
        (kMargin * std::max(vertices_per_path, 0.1) * static_cast<double>(bytes_of_vertex(params.merging())));
    return static_cast<float>(std::min(room, 1e9) / static_cast<double>(size.pixels()));
}

/// `paths_over_pilot`: of a pass.
float first_merge_radius_m(const MergingParams& merging, const LightPaths& pilot, float scene_radius_m,
                           double paths_over_pilot) {
    const RadiusLimits limits(scene_radius_m);
    if (merging.radius_m) return *merging.radius_m;
    if (merging.radius_relative) return std::max(*merging.radius_relative * scene_radius_m, limits.least_m);
    // Caustics are sharp and dense where the rest is smooth: the one radius is to suit both.
    float wanted_m = limits.most_m;
    for (const bool caustic : {false, true}) {
        std::vector<Photon> photons;
        for (const LightVertex& v : pilot.vertices)
            if (!caustic || (v.all_delta && v.surfaces > 1))
                photons.push_back(
                    {v.position, PhotonPayload::make(v.power_w, v.from, v.normal, v.surfaces, v.all_delta)});
        if (photons.size() < kPilotNearest) continue;
        wanted_m = std::min(
            wanted_m,
            radius_of_pilot(PhotonMap(std::move(photons), {PhotonSearch::Kind::Nearest, kPilotNearest, limits.most_m}),
                            {.photons_in_radius = static_cast<double>(merging.nearest_vertices),
                             .bright_share = caustic ? kBrightCausticShare : kBrightShare,
                             .paths_over_pilot = paths_over_pilot}));
    }
    return std::max(wanted_m, limits.least_m);
}

uint32_t paths_of_pass(float light_paths, Size2 size) {
    return static_cast<uint32_t>(std::lround(double{light_paths} * static_cast<double>(size.pixels())));
}

}  // namespace

struct BidirectionalMethod::State {
    struct PerThread {
        EyePathTracer eye;
        std::optional<PathWavefront> eye_alone;
        Counts counts;
        EyeSeconds seconds;
    };

    State(const RenderContext& context, const BidirectionalParams& params)
        : scene(context, params),
          light(scene),
          budget(context.budget),
          image(context.view.film_size, context.view.layers) {}

    /// How many light paths, and what is expected of them.
    void plan(const RenderContext& context, const BidirectionalParams& params, Stats& stats);

    const BidirectionalScene scene;
    LightPathTracer light;
    MemoryBudget& budget;
    PassTechniques techniques;
    float first_radius_m = 0;
    std::optional<EdgeTree> edges;  // that merging keeps off
    uint64_t most_light_bytes = 0;
    ThreadLocal<PerThread> threads;
    PassImage image;
    bool pass_complete = false;
};

void BidirectionalMethod::State::plan(const RenderContext& context, const BidirectionalParams& params, Stats& stats) {
    const StageTimer timer(stats, "pilot");
    const Size2 size = scene.view.film_size;
    techniques.own_path = params.connections == Connections::OwnPath;
    techniques.correlated = params.merging() != nullptr && params.merging()->weights == MergeWeights::CorrelationAware;
    double vertices = 0;  // of a light path
    if (scene.emission.total_power_w() > 0 && params.light_paths.value_or(1) > 0) {
        PassTechniques pilot;
        pilot.light_paths = std::min(kPilotPaths, static_cast<uint32_t>(size.pixels()));
        Counts counts;
        const LightPaths& paths = light.trace(hash64(scene.seed) ^ kPilotSeed, 0, pilot, counts, CancelToken{});
        stats.counts.photon_rays += counts.photon_rays;
        vertices = static_cast<double>(paths.vertices.size()) / pilot.light_paths;
        if (params.merging() != nullptr && vertices > 0) {
            const float light_paths =
                std::min(params.light_paths.value_or(1), most_light_paths(params, size, vertices));
            first_radius_m =
                first_merge_radius_m(*params.merging(), paths, scene.scene.bounds.radius(),
                                     double{light_paths} * static_cast<double>(size.pixels()) / pilot.light_paths);
            edges.emplace(find_surface_edges(scene.scene, first_radius_m));
            budget.record("surface_edges", edges->bytes());
        }
    }
    const auto skip_light_paths = [&](const char* why) {
        const uint64_t paths = paths_of_pass(params.light_paths.value_or(1), size);
        stats.skipped.push_back({"light paths", why, paths * bytes_of_path(kExpectedVertices, params.merging())});
    };
    if (!(vertices > 0))
        return skip_light_paths(scene.emission.total_power_w() > 0 ? "light_paths is 0" : "the scene has no light");

    // Light of points, spots and suns by mirrors and glass: no path from the eye ends there, and what mirrors show of
    // it is connected, or merged.
    const bool by_delta_alone = has_delta_light_by_delta(scene.scene.needs);
    techniques.edge_share = scene.scene.needs.delta ? kEdgeShare : 0.0f;
    const TechniqueChoices choices{
        .light_paths = params.light_paths,
        .most_light_paths = most_light_paths(params, size, vertices),
        .connections = techniques.own_path ? std::optional<uint32_t>(1) : params.connections_per_vertex,
        .merges = first_radius_m > 0,
        .needs_light_paths = by_delta_alone,
        .needs_connections = by_delta_alone && !(first_radius_m > 0),
        .needs_merges = by_delta_alone && first_radius_m > 0};
    TechniqueCandidate chosen{.light_paths = std::min(params.light_paths.value_or(1), choices.most_light_paths),
                              .connections = choices.connections.value_or(1),
                              .merges = choices.merges};
    if (params.adapt) {
        const TechniquePilot judged = run_technique_pilot(
            {context, params, vertices, choices, first_radius_m, edges ? &*edges : nullptr, techniques.edge_share},
            stats);
        chosen = judged.candidates[judged.chosen].candidate;
        if (!(chosen.light_paths > 0))
            return skip_light_paths("paths from the eye alone are worth more here, a pilot says");
        constexpr const char* kNotWorth = "they are not worth their cost here, a pilot says";
        if (chosen.connections == 0 && !params.connections_per_vertex)
            stats.skipped.push_back({"connections", kNotWorth, 0});
        if (choices.merges && !chosen.merges) stats.skipped.push_back({"merging", kNotWorth, 0});
    }
    techniques.light_paths = std::max(paths_of_pass(chosen.light_paths, size), 1u);
    techniques.connections_per_vertex = chosen.connections;
    techniques.numbers = {.light_paths = static_cast<float>(techniques.light_paths),
                          .connections = techniques.own_path ? 1.0f : static_cast<float>(chosen.connections / vertices),
                          .merges = chosen.merges};
    techniques.correlated = techniques.correlated && chosen.merges;
    budget.require("light_vertices", techniques.light_paths *
                                         bytes_of_path(kMargin * vertices, chosen.merges ? params.merging() : nullptr));
}

BidirectionalMethod::BidirectionalMethod(std::unique_ptr<const BidirectionalParams> params)
    : params_(std::move(params)) {}
BidirectionalMethod::~BidirectionalMethod() = default;

uint64_t BidirectionalMethod::estimate_bytes(const BidirectionalParams& params, const Workload& workload) {
    const float light_paths = std::min(params.light_paths.value_or(params.adapt ? 2.0f : 1.0f),
                                       most_light_paths(params, workload.film_size, kExpectedVertices));
    const uint64_t paths = paths_of_pass(light_paths, workload.film_size);
    return PassImage::bytes_for(workload.film_size, workload.layers) +
           workload.threads * (EyePathTracer::bytes_per_thread() + PathWavefront::bytes_per_thread()) +
           LightPathTracer::scratch_bytes(workload.threads) +
           LightSampler::estimate_bytes(workload.lights, workload.environment_size) +
           EmissionSampler::estimate_bytes(workload.lights, workload.environment_size) +
           paths * bytes_of_path(kExpectedVertices, params.merging()) +
           (params.merging() != nullptr ? EdgeTree::estimate_bytes(workload.triangles) : 0);
}

void BidirectionalMethod::begin(const RenderContext& context, Stats& stats) {
    MemoryBudget& budget = context.budget;
    const uint64_t image_bytes = PassImage::bytes_for(context.view.film_size, context.view.layers);
    const uint64_t scratch_bytes =
        most_threads() * (EyePathTracer::bytes_per_thread() + PathWavefront::bytes_per_thread()) +
        LightPathTracer::scratch_bytes(most_threads());
    budget.require("pass_image", image_bytes);
    budget.require("wavefronts", image_bytes + scratch_bytes);
    state_ = std::make_unique<State>(context, *params_);
    budget.record("pass_image", image_bytes);
    budget.record("wavefronts", scratch_bytes);
    budget.record("light_sampler", state_->scene.lights.bytes() + state_->scene.ends.bytes());
    budget.record("emission_sampler", state_->scene.emission.bytes());
    if (!context.scene.needs.solid_glass) stats.skipped.push_back({"absorption", "no solid refracts", 0});
    state_->plan(context, *params_, stats);
}

void BidirectionalMethod::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    state.pass_complete = false;
    const BidirectionalScene& scene = state.scene;
    PassTechniques techniques = state.techniques;
    if (techniques.numbers.merges)
        techniques.merge_radius_m = state.first_radius_m * radius_share(pass, double{params_->merging()->alpha});
    if (state.edges) techniques.edges = &*state.edges, techniques.edge_radius_m = techniques.merge_radius_m;

    std::vector<uint32_t> in_grid_order;
    std::optional<HashGrid> grid;
    LightPaths& light = [&]() -> LightPaths& {
        const StageTimer timer(stats, "light_paths");
        LightPaths& traced = state.light.trace(scene.seed, pass, techniques, stats.counts, cancel);
        stats.counts.photons_stored += traced.vertices.size();
        if (techniques.own_path) traced.sort_by_path(techniques.light_paths);
        return traced;
    }();
    if (cancel.cancelled()) return;
    if (techniques.numbers.merges && !light.vertices.empty()) {
        const StageTimer timer(stats, "photon_map_build");
        in_grid_order.resize(light.vertices.size());
        grid.emplace(light.grid(techniques.merge_radius_m, in_grid_order));
    }
    state.most_light_bytes = std::max(state.most_light_bytes, state.light.bytes() + (grid ? grid->bytes() : 0) +
                                                                  in_grid_order.size() * sizeof(uint32_t));
    state.budget.record("light_vertices", state.most_light_bytes);

    const double wall_start = wall_now_seconds();
    const PassSampler sampler(scene.sampler, scene.seed, RandomDomain::Camera, pass);
    const JoinedPass joined{.techniques = techniques,
                            .light = light,
                            .grid = grid ? &*grid : nullptr,
                            .in_grid_order = in_grid_order,
                            .sampler = sampler,
                            .connection_salt = hash64(scene.seed) + pass};
    // Where nothing is to be joined, paths from the eye need no weights but light samples' own: they are path tracing.
    const bool eye_alone = techniques.light_paths == 0;
    const uint32_t side = eye_alone ? PathWavefront::kTileSide : EyePathTracer::kTileSide;
    parallel_over_tiles(scene.view.film_size, side, cancel, [&](const Tile& tile) {
        State::PerThread& mine = state.threads.local();
        if (eye_alone) {
            if (!mine.eye_alone) mine.eye_alone.emplace();
            mine.eye_alone->trace_tile(scene, sampler, tile, state.image, mine.counts, mine.seconds);
        } else {
            mine.eye.trace_tile(scene, joined, tile, state.image, mine.counts, mine.seconds);
        }
    });
    const EyeSeconds cpu = take_work(state.threads, stats);
    add_interleaved_stages(stats, wall_now_seconds() - wall_start,
                           {{"g_buffer", cpu.camera}, {"direct", cpu.direct}, {"indirect", cpu.indirect}});
    if (cancel.cancelled()) return;
    const StageTimer timer(stats, "light_image");
    light.add_splats(scene.filter, state.image);
    state.pass_complete = true;
}

void BidirectionalMethod::resolve(Film& film) {
    if (state_->pass_complete) film.add_pass(state_->image);
}

}  // namespace photond
