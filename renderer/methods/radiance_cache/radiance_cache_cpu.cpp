#include <algorithm>

#include "renderer/core/thread_local.h"
#include "renderer/eye/specular_walk.h"
#include "renderer/methods/radiance_cache/cache_training.h"
#include "renderer/methods/radiance_cache/cached_paths.h"
#include "renderer/methods/radiance_cache/radiance_cache.h"

namespace photond {

namespace {

constexpr uint32_t kTileSide = 16, kTrainingTileSide = CacheTraining::kTileSide;
constexpr size_t kSamplesOfTile =
    size_t{kTrainingTileSide} * kTrainingTileSide * CachedPaths::kMostRecords * (1 + CellGrid::kCoarserLevels);
constexpr uint32_t kMostTilesAtOnce = 1024;

uint64_t sample_bytes(const CacheTraining& training) {
    return training.tiles_of_round() * kSamplesOfTile * sizeof(CellSample);
}

/// Of the cells, and of the samples on their way to them.
uint64_t cell_bytes(const RadianceCacheParams& params, Size2 film_size) {
    return RadianceCells::bytes_for(params.cells) + CellsBetweenFrames::bytes_for(params) +
           sample_bytes(CacheTraining(film_size, params.training, kMostTilesAtOnce));
}

uint64_t scratch_bytes() {
    return SpecularWalk::bytes_per_thread(kTileSide) + CachedPaths::bytes_per_thread() +
           size_t{kTileSide} * kTileSide * sizeof(GatherPoint);
}

/// Rays that are gathered weigh against the light samples beside them.
class GatherGuide final : public WalkGuide {
public:
    explicit GatherGuide(uint32_t rays) : rays_(rays) {}
    WalkVertex decide(const Rgb& throughput, float eta_scale, bool waits) const override {
        return {1, waits ? split_of(rays_, throughput, eta_scale) : 0};
    }
    LightSeen light_seen(const vec3& /*position*/, const vec3& /*normal*/, uint32_t /*source*/) override {
        return LightSeen::Unknown;
    }

private:
    const uint32_t rays_;
};

/// Collects the points of a tile's vertex, and hands them on.
template <class Use>
class GatherPoints final : public VisiblePointSink {
public:
    GatherPoints(const SpecularWalk& walk, uint32_t rays, std::vector<GatherPoint>& points, const Use& use)
        : walk_(walk), rays_(rays), points_(points), use_(use) {}

    void take(std::span<const LambertVisiblePoint> lambert, std::span<const VisiblePoint> others) override {
        points_.clear();
        for (const LambertVisiblePoint& point : lambert) add(walk_.general(point));
        for (const VisiblePoint& point : others) add(point);
        use_(std::span<const GatherPoint>(points_));
    }

private:
    void add(const VisiblePoint& point) {
        points_.push_back({point, FinalGather::key(point.path_key, point.vertex),
                           split_of(rays_, point.throughput, point.eta_scale), 1});
    }

    const SpecularWalk& walk_;
    const uint32_t rays_;
    std::vector<GatherPoint>& points_;
    const Use& use_;
};

}  // namespace

struct RadianceCache::State {
    struct PerThread {
        SpecularWalk walk{kTileSide};
        CachedPaths paths;
        std::vector<GatherPoint> points;
        Counts counts;
        EyeSeconds seconds;
    };

    State(const RenderContext& context, const RadianceCacheParams& parameters, const CellsBetweenFrames& between)
        : params(parameters),
          frames(between),
          eye(context, parameters.sampler, parameters.max_scatterings()),
          training(context.view.film_size, parameters.training, kMostTilesAtOnce),
          image(context.view.film_size, context.view.layers) {
        if (why_no_cache(parameters, !eye.lights.empty())) return;
        cells.emplace(parameters.cells);
        aged = frames.aged(eye.seed);
        lists.resize(training.tiles_of_round());
        for (std::vector<CellSample>& list : lists) list.reserve(kSamplesOfTile);
    }

    bool fill(const CacheBlock& block, Stats& stats, const CancelToken& cancel);
    void fill_by_tile(uint64_t tile, const PassSampler& path, const SplitSamplers& numbers, bool ends_in_cells,
                      std::vector<CellSample>& samples, const CancelToken& cancel);
    void show_cells(std::span<const GatherPoint> points);
    uint32_t key() const { return cache_key(eye.seed, *filled); }

    const RadianceCacheParams& params;
    const CellsBetweenFrames& frames;
    const EyeScene eye;
    const CacheTraining training;
    std::optional<RadianceCells> cells;  // none: no path asks them
    std::optional<AgedCells> aged;       // that they begin with
    CellGrid grid;
    std::optional<CacheBlock> filled;            // what the cells are of
    std::vector<std::vector<CellSample>> lists;  // of a round, by tile
    PassImage image;
    ThreadLocal<PerThread> threads;
    bool pass_complete = false;  // image holds a whole pass
};

/// False: cancelled, and the cells are of no block.
bool RadianceCache::State::fill(const CacheBlock& block, Stats& stats, const CancelToken& cancel) {
    const StageTimer timer(stats, "cache_fill");
    cells->clear();
    if (aged) cells->begin_with(*aged);
    filled = block;
    grid = cache_grid(eye.scene.bounds, eye.view.camera.position, eye.seed, params, block);
    frames.place(grid);
    bool ends_in_cells = false;
    for (uint32_t i = 0; i < block.passes * training.times; ++i) {
        const uint32_t draw = block.first * training.times + i;
        const PassSampler path(eye.sampler, eye.seed, RandomDomain::CacheTraining, draw);
        const SplitSamplers numbers(eye.sampler, hash64(eye.seed), draw, 1);
        const std::vector<uint32_t> order = training.order(draw, key());
        for (uint64_t round = 0; round < training.rounds; ++round) {
            const uint64_t first = round * training.tiles_of_round();
            const uint64_t end = std::min(first + training.tiles_of_round(), training.tiles);
            for (std::vector<CellSample>& list : lists) list.clear();
            if (first >= end) break;
            parallel_for(end - first, 1, [&](size_t k) {
                if (cancel.cancelled()) return;
                fill_by_tile(order[first + k], path, numbers, ends_in_cells, lists[k], cancel);
            });
            if (cancel.cancelled()) {
                filled.reset();
                return false;
            }
            cells->add(lists);
            ends_in_cells = params.second_bounces == SecondBounces::Cache && !params.indirect_bounces;
        }
    }
    stats.counts.cache_refused += cells->refused();
    return true;
}

void RadianceCache::State::fill_by_tile(uint64_t tile, const PassSampler& path, const SplitSamplers& numbers,
                                        bool ends_in_cells, std::vector<CellSample>& samples,
                                        const CancelToken& cancel) {
    PerThread& mine = threads.local();
    const Size2 size = eye.view.film_size;
    const auto x = static_cast<uint32_t>(tile % training.columns) * kTrainingTileSide;
    const auto y = static_cast<uint32_t>(tile / training.columns) * kTrainingTileSide;
    const CachedPaths::Pass pass{eye,     params,        grid,  ends_in_cells ? &*cells : nullptr,
                                 numbers, hash32(key()), image, mine.counts};
    const auto use = [&](std::span<const GatherPoint> points) { mine.paths.train(pass, points, samples, cancel); };
    GatherPoints sink(mine.walk, 1, mine.points, use);
    EyeSeconds seconds;  // the whole is timed
    mine.walk.trace_tile(
        eye, {params.glossy_threshold, nullptr}, {path, {&path, 1}},
        {x, y, std::min(x + kTrainingTileSide, size.width), std::min(y + kTrainingTileSide, size.height)}, image,
        mine.counts, seconds, cancel, sink);
}

void RadianceCache::State::show_cells(std::span<const GatherPoint> points) {
    for (const GatherPoint& point : points) {
        if (point.scatterings > 0) continue;
        const vec3& position = point.surface.position;
        const std::optional<uint32_t> level = grid.level(glm::distance(position, grid.eye), kInfinity);
        if (!level) continue;
        const Frame& shading = point.surface.shading;
        const uint32_t direction = cell_direction(point.rough, shading.to_world(point.wo), params.direction_bins);
        const CellKey key = grid.key(position, shading.normal, direction, *level);
        if (image.layers.has(Layer::CacheCells))
            for (int c = 0; c < 3; ++c)
                image.of<Layer::CacheCells>()[point.pixel][c] =
                    to_unit_float(hash32(key.fingerprint + static_cast<uint32_t>(c)));
        if (image.layers.has(Layer::CacheSamples))
            image.of<Layer::CacheSamples>()[point.pixel] = static_cast<float>(cells->find(key).samples);
    }
}

RadianceCache::RadianceCache(const RadianceCacheParams& params) : FollowsFrames(params), params_(params) {}
RadianceCache::~RadianceCache() = default;

uint64_t RadianceCache::estimate_bytes(const RadianceCacheParams& params, const Workload& workload) {
    const bool lights = workload.lights > 0 || workload.environment_size.pixels() > 0;
    return PassImage::bytes_for(workload.film_size, workload.layers) +
           (why_no_cache(params, lights) ? 0 : cell_bytes(params, workload.film_size)) +
           workload.threads * scratch_bytes() +
           LightSampler::estimate_bytes(workload.lights, workload.environment_size);
}

void RadianceCache::begin(const RenderContext& context, Stats& stats) {
    const Scene& scene = context.scene;
    const bool lights = scene.needs.area_lights || scene.needs.punctual_lights || scene.needs.environment;
    const char* const why_none = why_no_cache(params_, lights);
    const uint64_t image_bytes = PassImage::bytes_for(context.view.film_size, context.view.layers);
    const uint64_t path_bytes = most_threads() * scratch_bytes();
    const uint64_t all_cells = cell_bytes(params_, context.view.film_size);
    context.budget.require("radiance_cache", image_bytes + path_bytes + (why_none ? 0 : all_cells));
    state_ = std::make_unique<State>(context, params_, frames_);
    context.budget.record("pass_image", image_bytes);
    context.budget.record("wavefronts", path_bytes);
    context.budget.record("light_sampler", state_->eye.lights.bytes());
    if (why_none)
        stats.skipped.push_back({"radiance cache", why_none, all_cells});
    else
        context.budget.record("radiance_cache", all_cells);
    if (scene.needs.only_lambert())
        stats.skipped.push_back({"directions of cells", "every surface is a plain Lambert reflector", 0});
}

void RadianceCache::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    state.pass_complete = false;
    const CacheBlock block = cache_block_of(pass);
    if (state.cells && (!state.filled || state.filled->first != block.first)) {
        if (!state.fill(block, stats, cancel)) return;
        take_work(state.threads, stats);
    }

    const double wall_start = wall_now_seconds();
    const PassSampler path(state.eye.sampler, state.eye.seed, RandomDomain::Camera, pass);
    const SplitSamplers numbers(state.eye.sampler, state.eye.seed, pass, params_.gather_rays);
    const bool shows_cells =
        state.cells && (state.image.layers.has(Layer::CacheCells) || state.image.layers.has(Layer::CacheSamples));
    parallel_over_tiles(state.eye.view.film_size, kTileSide, cancel, [&](const Tile& tile) {
        State::PerThread& mine = state.threads.local();
        const CachedPaths::Pass gathering{state.eye,   params_,
                                          state.grid,  state.cells ? &*state.cells : nullptr,
                                          numbers,     state.filled ? hash32(state.key() + pass) : 0,
                                          state.image, mine.counts};
        GatherGuide guide(params_.gather_rays);
        const auto use = [&](std::span<const GatherPoint> points) {
            if (shows_cells) state.show_cells(points);
            mine.paths.gather(gathering, points, cancel);
        };
        GatherPoints sink(mine.walk, params_.gather_rays, mine.points, use);
        mine.walk.trace_tile(state.eye, {params_.glossy_threshold, &guide}, {path, {&path, 1}}, tile, state.image,
                             mine.counts, mine.seconds, cancel, sink);
    });

    const EyeSeconds cpu = take_work(state.threads, stats);
    add_interleaved_stages(
        stats, wall_now_seconds() - wall_start,
        {{"g_buffer", cpu.camera}, {"direct", cpu.direct}, {"indirect", cpu.indirect}, {"gather", cpu.points}});
    state.pass_complete = !cancel.cancelled();
    if (state.pass_complete && state.cells && frames_.lacks(block))
        frames_.leave(block, state.grid, [&](LeftCells& left) {
            state.cells->for_each(
                [&](uint32_t slot, uint32_t fingerprint, const RadianceCells::Mean& mean, uint32_t last_round) {
                    frames_.append(left, slot, fingerprint, mean.radiance, mean.samples, last_round);
                });
        });
}

PassImage* RadianceCache::end_pass() { return state_->pass_complete ? &state_->image : nullptr; }

}  // namespace photond
