#include "renderer/methods/radiance_cache/radiance_cells_gpu.h"

#include <bit>
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

RadianceCellsGpu::RadianceCellsGpu(gpu::Device& device, uint32_t cells, uint32_t paths, bool aged)
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
      add_(device, cache_shader("cache_add.comp"), sizeof(gpu::CacheRoundPush)) {
    if (!aged) return;
    aged_.emplace(Table{{device, kCells, fingerprints_.bytes()}, {device, kCells, sums_.bytes()}});
    host_.emplace(Table{{device, "readback", fingerprints_.bytes(), gpu::MemoryKind::Readback},
                        {device, "readback", sums_.bytes(), gpu::MemoryKind::Readback}});
}

uint64_t RadianceCellsGpu::device_bytes(uint32_t cells, uint32_t paths, bool aged) {
    const uint64_t buckets = RadianceCells::buckets_for(cells), tables = aged ? 3 : 1;
    return sizeof(uint32_t) * buckets * (tables * CACHE_SLOTS * (1 + CACHE_SUM_WORDS) + 1) +
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
    commands.fill(older_, 0);
    commands.fill(state_, 0, CACHE_BRIGHTEST * sizeof(uint32_t), (CACHE_FOUND + 1) * sizeof(uint32_t));
    if (!aged_) {
        for (gpu::Buffer* buffer : {&fingerprints_, &sums_}) commands.fill(*buffer, 0);
        return;
    }
    commands.update(state_, std::as_bytes(std::span(&brightest_, 1)), CACHE_BRIGHTEST * sizeof(uint32_t));
    commands.copy(aged_->fingerprints, 0, fingerprints_, 0, fingerprints_.bytes());
    commands.copy(aged_->sums, 0, sums_, 0, sums_.bytes());
}

void RadianceCellsGpu::begin_with(gpu::Device& device, const AgedCells& aged) {
    first_round_ = aged.round;
    brightest_ = aged.unit * static_cast<float>(CACHE_UNITS_OF_MOST);  // by a power of two
    const size_t slots = size_t{buckets_} * CACHE_SLOTS;
    std::vector<uint32_t> fingerprints(slots), sums(slots * CACHE_SUM_WORDS);
    for (const AgedCell& cell : aged.cells) {
        fingerprints[cell.slot] = cell.fingerprint;
        uint32_t* const words = &sums[size_t{cell.slot} * CACHE_SUM_WORDS];
        for (int c = 0; c < 3; ++c) {
            words[2 * c] = static_cast<uint32_t>(cell.units[c]);
            words[2 * c + 1] = static_cast<uint32_t>(cell.units[c] >> 32);
        }
        words[CACHE_SAMPLES_WORD] = cell.samples, words[CACHE_ROUND_WORD] = cell.last_round;
    }
    gpu::upload(device, aged_->fingerprints, std::as_bytes(std::span(fingerprints)));
    gpu::upload(device, aged_->sums, std::as_bytes(std::span(sums)));
}

void RadianceCellsGpu::record_leave(gpu::CommandList& commands) {
    commands.copy(fingerprints_, 0, host_->fingerprints, 0, fingerprints_.bytes());
    commands.copy(sums_, 0, host_->sums, 0, sums_.bytes());
    commands.host_reads(host_->fingerprints);
    commands.host_reads(host_->sums);
}

void RadianceCellsGpu::leave(const CellsBetweenFrames& frames, LeftCells& left) const {
    const std::span<const uint32_t> fingerprints = host_->fingerprints.as<uint32_t>(),
                                    sums = host_->sums.as<uint32_t>();
    const double unit = double{std::bit_cast<float>(host_state_.as<uint32_t>()[CACHE_BRIGHTEST])} / CACHE_UNITS_OF_MOST;
    for (uint32_t slot = 0; slot < fingerprints.size(); ++slot) {
        const std::span<const uint32_t> cell = sums.subspan(size_t{slot} * CACHE_SUM_WORDS, CACHE_SUM_WORDS);
        const uint32_t samples = cell[CACHE_SAMPLES_WORD];
        if (samples == 0) continue;
        vec3 mean;
        for (int c = 0; c < 3; ++c)
            mean[c] =
                static_cast<float>(static_cast<double>(uint64_t{cell[2 * c + 1]} << 32 | cell[2 * c]) * unit / samples);
        frames.append(left, slot, fingerprints[slot], mean, samples, cell[CACHE_ROUND_WORD]);
    }
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
