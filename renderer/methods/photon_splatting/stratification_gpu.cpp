#include "renderer/methods/photon_splatting/stratification_gpu.h"

#include <array>
#include <bit>

#include "renderer/photons/reflected_photon_shared.h"

namespace photond {

namespace {

static_assert(sizeof(gpu::SplatSourceRecord) == sizeof(SplatSource));
static_assert(REPRESENTATIVE_RANDOM == static_cast<uint32_t>(Representative::Random) &&
              REPRESENTATIVE_BY_POWER == static_cast<uint32_t>(Representative::ByPower) &&
              REPRESENTATIVE_CLOSEST_TO_MEAN == static_cast<uint32_t>(Representative::ClosestToMean) &&
              REPRESENTATIVE_DOMINANT_DIRECTION == static_cast<uint32_t>(Representative::DominantDirection));

constexpr const char* kStructure = "stratification";
constexpr uint32_t kKeyBits = 32;

std::string stratify_shader(const char* step) {
    return std::string("renderer/methods/photon_splatting/stratify_") + step + ".comp";
}

/// Bits of a key: the codes of cells, of what is outside, and one more for photons without power.
uint32_t key_bits(uint32_t cells) { return 3 * static_cast<uint32_t>(std::bit_width(cells + 3)) + 1; }

}  // namespace

StratificationGpu::StratificationGpu(gpu::Device& device, const StratificationSettings& settings)
    : device_(device),
      settings_(settings),
      wide_(key_bits(settings.cells) > kKeyBits),
      state_(device, kStructure, STRATIFICATION_STATE_WORDS * sizeof(uint32_t)),
      host_state_(device, "readback", state_.bytes(), gpu::MemoryKind::Readback),
      key_(device, stratify_shader("keys"), sizeof(gpu::StratificationConstants)),
      join_(device, stratify_shader("join"), sizeof(gpu::StratificationConstants), nullptr,
            {gpu::specialize(STRATIFICATION_WIDE_ID, wide_)}),
      count_(device, stratify_shader("count"), sizeof(gpu::StratificationConstants), nullptr,
             {gpu::specialize(STRATIFICATION_WIDE_ID, wide_)}),
      choose_(device, stratify_shader("choose"), sizeof(gpu::StratificationConstants), nullptr,
              {gpu::specialize(STRATIFICATION_WIDE_ID, wide_)}) {}

uint64_t StratificationGpu::device_bytes(uint64_t photons, uint32_t minimum_photons) {
    // Keys, places, what the sort swaps them with, and offsets; where cells are joined, covers and levels. The sort
    // counts, 1 KiB a tile of 1024 where subgroups are small.
    const uint64_t words = 5 + (minimum_photons > 1 ? 2 : 0);
    return photons * (words * sizeof(uint32_t) + sizeof(gpu::SplatSourceRecord) + 1);
}

void StratificationGpu::make_room(uint32_t photons) {
    if (photons <= capacity_) return;
    keys_ = {}, places_ = {}, covers_ = {}, joined_ = {}, offsets_ = {}, sources_ = {};  // not both at once
    sort_.reset(), sum_.reset();
    capacity_ = photons;
    const auto words = [&](uint64_t count) { return gpu::Buffer(device_, kStructure, count * sizeof(uint32_t)); };
    keys_ = words(photons);
    places_ = words(photons);
    covers_ = words(joins() ? photons : 1);
    joined_ = words(joins() ? photons : 1);
    offsets_ = words(photons);
    // No photon makes more than one splat of its own.
    sources_ = gpu::Buffer(device_, kStructure, uint64_t{photons} * sizeof(gpu::SplatSourceRecord));
    sort_.emplace(device_, photons);
    sum_.emplace(device_, photons);
}

void StratificationGpu::start(uint64_t seed, uint32_t pass, uint32_t photons) {
    make_room(std::max(photons, 1u));
    const StratificationGrid grid(settings_, seed, pass);
    push_ = {.seed = seed,
             .pass = pass,
             .photons = photons,
             .grid_min = grid.min,
             .cells_per_m = grid.cells_per_m,
             .low = grid.low,
             .levels = grid.levels,
             .high = grid.high,
             .minimum_photons = settings_.minimum_photons,
             .first = grid.first,
             .splats_per_cell = settings_.splats_per_cell,
             .representative = static_cast<uint32_t>(settings_.representative),
             .mean_power = settings_.mean_power};
}

void StratificationGpu::record_sort(gpu::CommandList& commands, gpu::Buffer& photons, gpu::Buffer& order) {
    const uint32_t bits = key_bits(settings_.cells);
    for (uint32_t first_bit = 0; first_bit < bits; first_bit += kKeyBits) {
        gpu::StratificationConstants push = push_;
        push.high_bits = first_bit > 0;
        commands.bind(key_, {gpu::read("photons", photons), gpu::read("order", order),
                             gpu::read_write("places", places_), gpu::write("keys", keys_)});
        commands.push(push);
        commands.dispatch_threads(push_.photons, STRATIFICATION_GROUP);
        sort_->record(commands, keys_, places_, {state_, STRATIFICATION_PHOTONS}, std::min(bits - first_bit, kKeyBits));
    }
}

void StratificationGpu::record(gpu::CommandList& commands, gpu::Buffer& photons, gpu::Buffer& order) {
    std::array<uint32_t, STRATIFICATION_STATE_WORDS> words{};
    words[STRATIFICATION_PHOTONS] = push_.photons;
    commands.update(state_, words);
    if (push_.photons > 0) {
        const gpu::Scope scope(commands, "stratify");
        record_sort(commands, photons, order);
        if (joins()) {
            commands.fill(covers_, 0);
            commands.fill(joined_, 0);
            commands.bind(join_, {gpu::read("photons", photons), gpu::read("order", order), gpu::read("keys", keys_),
                                  gpu::read("places", places_), gpu::read_write("covers", covers_),
                                  gpu::read_write("joined", joined_)});
            commands.push(push_);
            commands.dispatch_threads(push_.photons, STRATIFICATION_GROUP);
            sum_->record(commands, covers_, covers_, {state_, STRATIFICATION_PHOTONS}, {state_, STRATIFICATION_COVERS});
        }
        commands.bind(count_, {gpu::read("photons", photons), gpu::read("order", order), gpu::read("keys", keys_),
                               gpu::read("places", places_), gpu::read("covers", covers_), gpu::read("joined", joined_),
                               gpu::write("splats", offsets_)});
        commands.push(push_);
        commands.dispatch_threads(push_.photons, STRATIFICATION_GROUP);
        sum_->record(commands, offsets_, offsets_, {state_, STRATIFICATION_PHOTONS}, {state_, STRATIFICATION_SOURCES});
        commands.bind(choose_, {gpu::read("photons", photons), gpu::read("order", order), gpu::read("keys", keys_),
                                gpu::read("places", places_), gpu::read("state", state_), gpu::read("joined", joined_),
                                gpu::read("offsets", offsets_), gpu::write("sources", sources_)});
        commands.push(push_);
        commands.dispatch_threads(push_.photons, STRATIFICATION_GROUP);
    }
    commands.copy(state_, 0, host_state_, 0, state_.bytes());
    commands.host_reads(host_state_);
}

}  // namespace photond
