#include "renderer/methods/radiance_cache/radiance_cells.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "renderer/core/parallel.h"
#include "renderer/core/rng.h"
#include "renderer/methods/radiance_cache/aged_cells.h"

namespace photond {

namespace {

constexpr size_t kBucketsAtOnce = 1024;

/// The mean of all channels of all samples: in their order, so that it is the same for any number of threads.
double mean_of_lists(std::span<const std::vector<CellSample>> lists) {
    double sum = 0;
    uint64_t samples = 0;
    for (const std::vector<CellSample>& list : lists) {
        for (const CellSample& sample : list)
            sum += double{sample.radiance.x} + double{sample.radiance.y} + double{sample.radiance.z};
        samples += list.size();
    }
    return samples > 0 ? sum / (3 * static_cast<double>(samples)) : 0;
}

/// Whole units, up or down by chance.
uint64_t rounded_by_chance(float units, uint32_t random) {
    const float most = std::min(units, RadianceCells::kMostUnits), whole = std::floor(most);
    return static_cast<uint64_t>(whole) + (to_unit_float(random) < most - whole ? 1 : 0);
}

}  // namespace

uint32_t RadianceCells::buckets_for(uint32_t cells) { return std::bit_ceil((cells + kSlots - 1) / kSlots); }

RadianceCells::RadianceCells(uint32_t cells)
    : buckets_(buckets_for(cells)),
      fingerprints_(size_t{buckets_} * kSlots),
      sums_(size_t{buckets_} * kSlots),
      older_(buckets_) {}

uint64_t RadianceCells::bytes_for(uint32_t cells) {
    return buckets_for(cells) * (kSlots * (sizeof(uint32_t) + sizeof(Sums)) + sizeof(uint8_t));
}

void RadianceCells::clear() {
    parallel_for(buckets_, kBucketsAtOnce, [&](size_t bucket) {
        for (size_t slot = bucket * kSlots; slot < (bucket + 1) * kSlots; ++slot) {
            fingerprints_[slot].store(0, std::memory_order_relaxed);
            for (auto& sum : sums_[slot].radiance) sum.store(0, std::memory_order_relaxed);
            sums_[slot].samples.store(0, std::memory_order_relaxed);
        }
        older_[bucket] = 0;
    });
    round_ = 0;
    unit_ = 0;
    refused_ = evicted_ = 0;
}

void RadianceCells::begin_with(const AgedCells& aged) {
    round_ = aged.round;
    unit_ = double{aged.unit};
    for (const AgedCell& cell : aged.cells) {
        fingerprints_[cell.slot].store(cell.fingerprint, std::memory_order_relaxed);
        Sums& sums = sums_[cell.slot];
        for (int c = 0; c < 3; ++c) sums.radiance[c].store(cell.units[c], std::memory_order_relaxed);
        sums.samples.store(cell.samples, std::memory_order_relaxed);
        sums.last_round = cell.last_round;
    }
}

void RadianceCells::add(std::span<const std::vector<CellSample>> lists) {
    if (unit_ == 0) unit_ = mean_of_lists(lists) / kUnitsOfMean;
    ++round_;
    std::atomic<uint64_t> evicted = 0, refused = 0;
    parallel_for(buckets_, kBucketsAtOnce, [&](size_t bucket) { make_room(static_cast<uint32_t>(bucket), evicted); });
    parallel_for(lists.size(), 1, [&](size_t list) {
        for (const CellSample& sample : lists[list]) insert(sample.key);
    });
    parallel_for(lists.size(), 1, [&](size_t list) {
        uint64_t without_place = 0;
        for (const CellSample& sample : lists[list])
            if (!add(sample)) ++without_place;
        refused.fetch_add(without_place, std::memory_order_relaxed);
    });
    evicted_ += evicted;
    refused_ += refused;
}

/// Tells where new cells may go, and makes place for one where there is none: cells move up in their order.
void RadianceCells::make_room(uint32_t bucket, std::atomic<uint64_t>& evicted) {
    const size_t first = size_t{bucket} * kSlots;
    uint32_t cells = 0;
    while (cells < kSlots && fingerprints_[first + cells].load(std::memory_order_relaxed) != 0) ++cells;
    if (cells == kSlots) {
        uint32_t kept = 0;
        for (uint32_t slot = 0; slot < kSlots; ++slot) {
            Sums& from = sums_[first + slot];
            const bool old = from.last_round + kMostAge < round_;
            if (!old && kept < slot) {
                Sums& to = sums_[first + kept];
                for (int c = 0; c < 3; ++c) to.radiance[c].store(from.radiance[c]);
                to.samples.store(from.samples);
                to.last_round = from.last_round;
                fingerprints_[first + kept].store(fingerprints_[first + slot]);
            }
            if (!old) ++kept;
        }
        for (uint32_t slot = kept; slot < kSlots; ++slot) {
            fingerprints_[first + slot].store(0);
            for (auto& sum : sums_[first + slot].radiance) sum.store(0);
            sums_[first + slot].samples.store(0);
        }
        if (kept < kSlots) evicted.fetch_add(kSlots - kept, std::memory_order_relaxed);
        cells = kept;
    }
    older_[bucket] = static_cast<uint8_t>(cells);
}

void RadianceCells::insert(const CellKey& key) {
    const uint32_t bucket = bucket_of(key), older = older_[bucket];
    std::atomic<uint32_t>* const slots = &fingerprints_[size_t{bucket} * kSlots];
    for (uint32_t slot = 0; slot < older; ++slot)
        if (slots[slot].load(std::memory_order_relaxed) == key.fingerprint) return;
    uint32_t carried = key.fingerprint;
    for (uint32_t slot = older; slot < kSlots && carried != 0; ++slot) {
        uint32_t there = slots[slot].load(std::memory_order_relaxed);
        while (there < carried && !slots[slot].compare_exchange_weak(there, carried, std::memory_order_relaxed)) {
        }
        if (there == carried) return;
        carried = std::min(carried, there);
    }
}

uint32_t RadianceCells::slot_of(const CellKey& key) const {
    const uint32_t first = bucket_of(key) * kSlots;
    for (uint32_t slot = first; slot < first + kSlots; ++slot)
        if (fingerprints_[slot].load(std::memory_order_relaxed) == key.fingerprint) return slot;
    return kNoSlot;
}

bool RadianceCells::add(const CellSample& sample) {
    const uint32_t slot = slot_of(sample.key);
    if (slot == kNoSlot) return false;
    Sums& sums = sums_[slot];
    std::atomic_ref(sums.last_round).store(round_, std::memory_order_relaxed);
    sums.samples.fetch_add(1, std::memory_order_relaxed);
    if (unit_ == 0) return true;  // all samples are black
    uint32_t random = sample.random;
    for (int c = 0; c < 3; ++c) {
        random = hash32(random + static_cast<uint32_t>(c));
        const auto units = static_cast<float>(double{sample.radiance[c]} / unit_);
        sums.radiance[c].fetch_add(rounded_by_chance(units, random), std::memory_order_relaxed);
    }
    return true;
}

RadianceCells::Mean RadianceCells::find(const CellKey& key) const {
    const uint32_t slot = slot_of(key);
    return slot == kNoSlot ? Mean{} : mean_of(sums_[slot]);
}

RadianceCells::Mean RadianceCells::mean_of(const Sums& sums) const {
    const uint32_t samples = sums.samples.load(std::memory_order_relaxed);
    if (samples == 0) return {};
    const double scale = unit_ / samples;
    Mean mean{.samples = samples};
    for (int c = 0; c < 3; ++c)
        mean.radiance[c] =
            static_cast<float>(scale * static_cast<double>(sums.radiance[c].load(std::memory_order_relaxed)));
    return mean;
}

uint64_t RadianceCells::cells() const {
    return static_cast<uint64_t>(std::count_if(fingerprints_.begin(), fingerprints_.end(), [](const auto& fingerprint) {
        return fingerprint.load(std::memory_order_relaxed) != 0;
    }));
}

}  // namespace photond
