#include "renderer/methods/radiance_cache/radiance_cache_gpu.h"

#include <algorithm>

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/eye/eye_constants.h"
#include "renderer/eye/tiles.h"
#include "renderer/frame/device_frame.h"
#include "renderer/methods/radiance_cache/cache_training.h"
#include "renderer/methods/radiance_cache/radiance_cells.h"
#include "renderer/methods/radiance_cache/radiance_cells_gpu.h"
#include "renderer/scene/scene.h"
#include "renderer/transport/roulette_shared.h"

namespace photond {

namespace {

static_assert(CacheTraining::kTileSide == EYE_TILE);

constexpr uint32_t kMostDeviceTiles = 256;  // of a round

CacheTraining device_training(const RadianceCacheParams& params, Size2 size) {
    return {size, params.training, kMostDeviceTiles};
}
uint32_t paths_of_round(const CacheTraining& training) {
    return static_cast<uint32_t>(training.tiles_of_round() * kEyeTilePixels);
}

std::string cached_shader(const char* name) { return "renderer/methods/radiance_cache/" + std::string(name); }

}  // namespace

struct RadianceCacheGpu::State {
    State(const RenderContext& context, const RadianceCacheParams& p, bool uses_cells,
          const CellsBetweenFrames& between)
        : params(p),
          frames(between),
          scene(*context.device_scene),
          device(scene.device()),
          seed(context.seed),
          view_eye(context.view.camera.position),
          training(device_training(p, context.view.film_size)),
          tiles(eye_tile_count(context.view.film_size)),
          eye(device, "eye", sizeof(gpu::EyeConstants)),
          sampler(device, "sampler", sizeof(gpu::PassSamplerData)),
          order(device, "radiance_cache", training.all() * sizeof(uint32_t)),
          cells(device, uses_cells ? p.cells : RadianceCells::kLeastCells, uses_cells ? paths_of_round(training) : 1,
                uses_cells && p.aged),
          asks(uses_cells),
          shows(context.view.layers.has(Layer::CacheCells) || context.view.layers.has(Layer::CacheSamples)),
          frame(context, [this](uint32_t pass, DeviceFrame::Steps& steps) { add_steps(pass, steps); }),
          gather(device, cached_shader("cache_gather.comp"), sizeof(gpu::CacheGatherPush), &scene.set(),
                 scene.specialization()) {
        const gpu::EyeConstants of_view = make_eye_constants(context.view, p.max_scatterings(), ROULETTE_START);
        gpu::upload(device, eye, std::as_bytes(std::span(&of_view, 1)));
        if (!asks) return;
        if (const auto aged = frames.aged(seed)) cells.begin_with(device, *aged);
        train.emplace(device, cached_shader("cache_train.comp"), sizeof(gpu::CacheTrainPush), &scene.set(),
                      scene.specialization());
    }
    ~State() { frame.end(); }

    void add_steps(uint32_t pass, DeviceFrame::Steps& steps);
    void add_fill_steps(const CacheBlock& block, DeviceFrame::Steps& steps);
    void add_draw_steps(const CacheBlock& block, uint32_t draw, DeviceFrame::Steps& steps);
    void record_round(gpu::CommandList& commands, uint64_t first, uint64_t end);
    void record_paths(gpu::CommandList& commands, uint32_t first, uint32_t end, bool shows_cells);
    std::vector<gpu::Binding> bindings();
    CellGrid grid_of(const CacheBlock& block) const;

    const RadianceCacheParams& params;
    const CellsBetweenFrames& frames;
    const gpu::DeviceScene& scene;
    gpu::Device& device;
    const uint64_t seed;
    const vec3 view_eye;
    const CacheTraining training;
    const uint32_t tiles;
    gpu::Buffer eye, sampler, order;
    RadianceCellsGpu cells;
    const bool asks, shows;
    std::optional<CacheBlock> filled;  // what the cells are of
    uint32_t round = 0;                // of the block
    DeviceFrame frame;
    gpu::ComputePipeline gather;
    std::optional<gpu::ComputePipeline> train;  // null: nobody asks
};

void RadianceCacheGpu::State::add_steps(uint32_t pass, DeviceFrame::Steps& steps) {
    const CacheBlock block = cache_block_of(pass);
    steps.push_back({0, [this](gpu::CommandList& commands) { cells.record_counts_clear(commands); }});
    if (asks && (!filled || filled->first != block.first)) add_fill_steps(block, steps);
    const uint32_t key = hash32(cache_key(seed, block) + pass);
    const uint32_t at_once = eye_tiles_at_once(tiles, device.paths_per_submit());
    for (uint32_t ray = 0; ray < params.gather_rays; ++ray) {
        steps.push_back({0, [=, this](gpu::CommandList& commands) {
                             if (asks) cells.record_key(commands, hash32(key ^ ray));
                             const uint32_t element = pass * params.gather_rays + ray;
                             commands.update(
                                 sampler,
                                 PassSampler(params.sampler, seed, RandomDomain::Camera, element).device_data());
                         }});
        for (uint32_t first = 0; first < tiles; first += at_once) {
            const uint32_t end = std::min(first + at_once, tiles);
            steps.push_back({uint64_t{end - first} * kEyeTilePixels, [=, this](gpu::CommandList& commands) {
                                 record_paths(commands, first, end, shows && ray == 0);
                             }});
        }
    }
    steps.push_back({0, [this](gpu::CommandList& commands) {
                         cells.record_counts(commands);
                         frame.image().record_readback(commands);
                     }});
}

CellGrid RadianceCacheGpu::State::grid_of(const CacheBlock& block) const {
    CellGrid grid = cache_grid(scene.scene().bounds, view_eye, seed, params, block);
    frames.place(grid);
    return grid;
}

void RadianceCacheGpu::State::add_fill_steps(const CacheBlock& block, DeviceFrame::Steps& steps) {
    steps.push_back({0, [=, this](gpu::CommandList& commands) {
                         filled.reset();  // until all is there
                         round = cells.first_round();
                         cells.record_clear(commands, grid_of(block), params, hash32(cache_key(seed, block)));
                     }});
    for (uint32_t i = 0; i < block.passes * training.times; ++i)
        add_draw_steps(block, block.first * training.times + i, steps);
    steps.push_back({0, [=, this](gpu::CommandList& commands) {
                         if (params.aged) cells.record_leave(commands);
                         filled = block;
                     }});
}

void RadianceCacheGpu::State::add_draw_steps(const CacheBlock& block, uint32_t draw, DeviceFrame::Steps& steps) {
    constexpr uint64_t kMostUpdate = 64 << 10;  // of CommandList::update()
    steps.push_back({0, [=, this](gpu::CommandList& commands) {
                         commands.update(
                             sampler,
                             PassSampler(params.sampler, seed, RandomDomain::CacheTraining, draw).device_data());
                         const std::vector<uint32_t> sorted = training.order(draw, cache_key(seed, block));
                         const auto bytes = std::as_bytes(std::span(sorted)).first(training.tiles * sizeof(uint32_t));
                         for (uint64_t at = 0; at < bytes.size(); at += kMostUpdate)
                             commands.update(order, bytes.subspan(at, std::min(kMostUpdate, bytes.size() - at)), at);
                     }});
    const uint64_t of_round = training.tiles_of_round();
    for (uint64_t first = 0; first < training.tiles; first += of_round) {
        const uint64_t end = std::min(first + of_round, training.tiles);
        steps.push_back({(end - first) * kEyeTilePixels,
                         [=, this](gpu::CommandList& commands) { record_round(commands, first, end); }});
    }
}

std::vector<gpu::Binding> RadianceCacheGpu::State::bindings() {
    std::vector<gpu::Binding> all = {gpu::read_write("device_layers", frame.image().layers()),
                                     gpu::read_write("device_counters", frame.image().counters()),
                                     gpu::read("eye", eye), gpu::read("pass_sampler", sampler)};
    cells.append_to(all);
    return all;
}

void RadianceCacheGpu::State::record_round(gpu::CommandList& commands, uint64_t first, uint64_t end) {
    const gpu::Scope scope(commands, "cache_fill");
    const bool ends_in_cells =
        params.second_bounces == SecondBounces::Cache && !params.indirect_bounces && round > cells.first_round();
    std::vector<gpu::Binding> all = bindings();
    all.insert(all.end(), {gpu::read("tiles", order), gpu::read_write("records", cells.records()),
                           gpu::write("record_counts", cells.record_counts())});
    commands.bind(*train, all);
    commands.push(
        gpu::CacheTrainPush{static_cast<uint32_t>(first), static_cast<uint32_t>(end), ends_in_cells ? 1u : 0u});
    const auto paths = static_cast<uint32_t>((end - first) * kEyeTilePixels);
    commands.dispatch_threads(paths, kEyeTilePixels);
    cells.record_add(commands, paths, ++round);
}

void RadianceCacheGpu::State::record_paths(gpu::CommandList& commands, uint32_t first, uint32_t end, bool shows_cells) {
    const gpu::Scope scope(commands, "indirect");
    commands.bind(gather, bindings());
    commands.push(gpu::CacheGatherPush{first, end, asks ? 1u : 0u, shows_cells ? 1u : 0u,
                                       1 / static_cast<float>(params.gather_rays)});
    commands.dispatch_threads(uint64_t{end - first} * kEyeTilePixels, kEyeTilePixels);
}

RadianceCacheGpu::RadianceCacheGpu(const RadianceCacheParams& params) : FollowsFrames(params), params_(params) {}
RadianceCacheGpu::~RadianceCacheGpu() = default;

uint64_t RadianceCacheGpu::estimate_bytes(const RadianceCacheParams& params, const Workload& workload) {
    return DeviceFrame::estimate_bytes(workload) + CellsBetweenFrames::bytes_for(params);
}

uint64_t RadianceCacheGpu::estimate_device_bytes(const RadianceCacheParams& params, const Workload& workload) {
    const CacheTraining training = device_training(params, workload.film_size);
    const bool lights = workload.lights > 0 || workload.environment_size.pixels() > 0;
    return DeviceFrame::estimate_device_bytes(workload) + sizeof(gpu::PassSamplerData) + sizeof(gpu::EyeConstants) +
           training.all() * sizeof(uint32_t) +
           (why_no_cache(params, lights)
                ? 0
                : RadianceCellsGpu::device_bytes(params.cells, paths_of_round(training), params.aged));
}

void RadianceCacheGpu::begin(const RenderContext& context, Stats& stats) {
    const Needs& needs = context.scene.needs;
    const char* const why_none = why_no_cache(params_, needs.area_lights || needs.punctual_lights || needs.environment);
    {
        const StageTimer timer(stats, "pipelines");
        state_ = std::make_unique<State>(context, params_, why_none == nullptr, frames_);
    }
    if (params_.aged) context.budget.record("radiance_cache", CellsBetweenFrames::bytes_for(params_));
    note_skipped_shading(needs, stats);
    if (why_none)
        stats.skipped.push_back(
            {"radiance cache", why_none,
             RadianceCellsGpu::device_bytes(params_.cells, paths_of_round(state_->training), params_.aged)});
    if (needs.only_lambert())
        stats.skipped.push_back({"directions of cells", "every surface is a plain Lambert reflector", 0});
}

void RadianceCacheGpu::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    const StageTimer timer(stats, "indirect");
    State& state = *state_;
    if (!state.frame.run(pass, stats, cancel)) return;
    stats.counts.cache_refused += state.cells.counted(CACHE_REFUSED);
    stats.counts.cache_hits += state.cells.counted(CACHE_HITS);
    stats.counts.cache_misses += state.cells.counted(CACHE_MISSES);
    state.frame.read(stats);
    if (const CacheBlock block = cache_block_of(pass); state.asks && frames_.lacks(block))
        frames_.leave(block, state.grid_of(block), [&](LeftCells& left) { state.cells.leave(frames_, left); });
}

DeviceFrame& RadianceCacheGpu::frame() { return state_->frame; }

}  // namespace photond
