#include "renderer/bidirectional/bidirectional_method.h"

#include "renderer/bidirectional/bidirectional_plan.h"
#include "renderer/bidirectional/eye_paths.h"
#include "renderer/core/thread_local.h"

namespace photond {

namespace {

uint64_t bytes_of_path(double vertices, const MergingParams* merging) {
    const double grid =
        merging != nullptr ? static_cast<double>(HashGrid::bytes_for(1u << 20)) / (1u << 20) + sizeof(uint32_t) : 0;
    // As they are traced, and put one behind the other.
    return static_cast<uint64_t>(
        vertices * (2.0 * static_cast<double>(bytes_of_light_vertex(merging) + sizeof(LightSplat)) + grid));
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

    const BidirectionalScene scene;
    LightPathTracer light;
    MemoryBudget& budget;
    BidirectionalPlan plan;
    uint64_t most_light_bytes = 0;
    ThreadLocal<PerThread> threads;
    PassImage image;
    bool pass_complete = false;
};

BidirectionalMethod::BidirectionalMethod(std::unique_ptr<const BidirectionalParams> params)
    : params_(std::move(params)) {}
BidirectionalMethod::~BidirectionalMethod() = default;

uint64_t BidirectionalMethod::estimate_bytes(const BidirectionalParams& params, const Workload& workload) {
    const float light_paths = std::min(params.light_paths.value_or(params.adapt ? 2.0f : 1.0f),
                                       most_light_paths(params, workload.film_size, kExpectedLightVertices));
    const uint64_t paths = paths_of_pass(light_paths, workload.film_size);
    return PassImage::bytes_for(workload.film_size, workload.layers) +
           workload.threads * (EyePathTracer::bytes_per_thread() + PathWavefront::bytes_per_thread()) +
           LightPathTracer::scratch_bytes(workload.threads) +
           LightSampler::estimate_bytes(workload.lights, workload.environment_size) +
           EmissionSampler::estimate_bytes(workload.lights, workload.environment_size) +
           paths * bytes_of_path(kExpectedLightVertices, params.merging()) +
           (params.merging() != nullptr ? EdgeTree::estimate_bytes(workload.triangles) : 0) +
           estimate_radii_bytes(params.merging());
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
    const BidirectionalPlan& plan = state_->plan = make_bidirectional_plan(
        context, *params_, state_->scene, state_->light, TechniquesBy::Block, bytes_of_path, stats);
    if (plan.coverage) budget.record("surface_edges", plan.coverage->bytes());
    if (plan.radii) budget.record("radii", plan.radii->bytes());
    if (plan.blocks) budget.record("technique_blocks", plan.blocks->bytes());
    budget.require("light_vertices",
                   plan.techniques.light_paths *
                       bytes_of_path(kLightVertexMargin * plan.vertices_per_path,
                                     plan.techniques.everywhere.numbers.merges ? params_->merging() : nullptr));
}

void BidirectionalMethod::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    state.pass_complete = false;
    const BidirectionalScene& scene = state.scene;
    const PassTechniques techniques = state.plan.of_pass(pass);

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
    if (techniques.everywhere.numbers.merges && !light.vertices.empty()) {
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
                            .join_salt = hash64(scene.seed) + pass};
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
    light.add_splats(scene.filter, techniques.blocks, state.image);
    state.pass_complete = true;
}

PassImage* BidirectionalMethod::end_pass() { return state_->pass_complete ? &state_->image : nullptr; }

}  // namespace photond
