#include "renderer/methods/radiance_cache/radiance_cells_gpu.h"

#include <cstddef>

#include "renderer/methods/radiance_cache/cached_paths.h"

namespace photond {

namespace {

static_assert(CACHE_SLOTS == RadianceCells::kSlots && CACHE_MOST_AGE == RadianceCells::kMostAge &&
              CACHE_FINER_LEVELS == CellGrid::kFinerLevels && CACHE_COARSER_LEVELS == CellGrid::kCoarserLevels &&
              CACHE_MOST_LEVEL == CellGrid::kMostLevel && CACHE_MOST_RECORDS == CachedPaths::kMostRecords);

constexpr const char* kCells = "radiance_cache";

std::string cache_shader(const char* name) { return "renderer/methods/radiance_cache/" + std::string(name); }
gpu::Buffer cache_words(gpu::Device& device, uint64_t count) { return {device, kCells, count * sizeof(uint32_t)}; }

}  // namespace

RadianceCellsGpu::RadianceCellsGpu(gpu::Device& device, uint32_t cells, uint32_t paths)
    : buckets_(RadianceCells::buckets_for(cells)),
      constants_(device, kCells, sizeof(gpu::CacheConstants)),
      state_(cache_words(device, CACHE_STATE_WORDS)),
      host_state_(device, "readback", state_.bytes(), gpu::MemoryKind::Readback),
      fingerprints_(cache_words(device, uint64_t{buckets_} * CACHE_SLOTS)),
      sums_(cache_words(device, uint64_t{buckets_} * CACHE_SLOTS * CACHE_SUM_WORDS)),
      older_(cache_words(device, buckets_)),
      records_(device, kCells, uint64_t{paths} * CACHE_MOST_RECORDS * sizeof(gpu::CacheRecord)),
      record_counts_(cache_words(device, paths)),
      room_(device, cache_shader("cache_room.comp"), sizeof(gpu::CacheRoundPush)),
      insert_(device, cache_shader("cache_insert.comp"), sizeof(gpu::CacheRoundPush)),
      add_(device, cache_shader("cache_add.comp"), sizeof(gpu::CacheRoundPush)) {}

uint64_t RadianceCellsGpu::device_bytes(uint32_t cells, uint32_t paths) {
    const uint64_t buckets = RadianceCells::buckets_for(cells);
    return sizeof(uint32_t) * buckets * (CACHE_SLOTS * (1 + CACHE_SUM_WORDS) + 1) +
           uint64_t{paths} * (CACHE_MOST_RECORDS * sizeof(gpu::CacheRecord) + sizeof(uint32_t));
}

void RadianceCellsGpu::record_clear(gpu::CommandList& commands, const CellGrid& grid, const RadianceCacheParams& params,
                                    uint32_t key) {
    commands.update(constants_, gpu::CacheConstants{.eye = grid.eye,
                                                    .coarsest_m = grid.coarsest_m,
                                                    .origin = grid.origin,
                                                    .of_distance = grid.of_distance,
                                                    .buckets = buckets_,
                                                    .least_samples = params.least_samples,
                                                    .direction_bins = params.direction_bins,
                                                    .glossy_threshold = params.glossy_threshold,
                                                    .bounces_are_limited = params.indirect_bounces ? 1u : 0u,
                                                    .key = key});
    for (gpu::Buffer* buffer : {&fingerprints_, &sums_, &older_}) commands.fill(*buffer, 0);
    commands.fill(state_, 0, CACHE_BRIGHTEST * sizeof(uint32_t), (CACHE_FOUND + 1) * sizeof(uint32_t));
}

void RadianceCellsGpu::record_key(gpu::CommandList& commands, uint32_t key) {
    commands.update(constants_, std::as_bytes(std::span(&key, 1)), offsetof(gpu::CacheConstants, key));
}

void RadianceCellsGpu::append_to(std::vector<gpu::Binding>& bindings) {
    bindings.insert(bindings.end(), {gpu::read("cache", constants_), gpu::read_write("cache_state", state_),
                                     gpu::read("fingerprints", fingerprints_), gpu::read("cell_sums", sums_)});
}

void RadianceCellsGpu::record_add(gpu::CommandList& commands, uint32_t paths, uint32_t round) {
    const auto run = [&](const gpu::ComputePipeline& pipeline, uint64_t threads) {
        std::vector<gpu::Binding> bindings = {gpu::read("cache", constants_),
                                              gpu::read_write("cache_state", state_),
                                              gpu::read_write("fingerprints", fingerprints_),
                                              gpu::read_write("cell_sums", sums_),
                                              gpu::read_write("older_cells", older_),
                                              gpu::read("records", records_),
                                              gpu::read("record_counts", record_counts_)};
        commands.bind(pipeline, bindings);
        commands.push(gpu::CacheRoundPush{paths, round});
        commands.dispatch_threads(threads, CACHE_GROUP);
    };
    run(room_, buckets_);
    run(insert_, uint64_t{paths} * CACHE_MOST_RECORDS);
    run(add_, uint64_t{paths} * CACHE_MOST_RECORDS);
}

void RadianceCellsGpu::record_counts_clear(gpu::CommandList& commands) {
    constexpr uint64_t kFirst = CACHE_REFUSED * sizeof(uint32_t);
    commands.fill(state_, 0, kFirst, state_.bytes() - kFirst);
}

void RadianceCellsGpu::record_counts(gpu::CommandList& commands) {
    commands.copy(state_, 0, host_state_, 0, state_.bytes());
    commands.host_reads(host_state_);
}

uint64_t RadianceCellsGpu::counted(uint32_t word) const {
    const std::span<const uint32_t> words = host_state_.as<uint32_t>();
    return uint64_t{words[word + 1]} << 32 | words[word];
}

}  // namespace photond
