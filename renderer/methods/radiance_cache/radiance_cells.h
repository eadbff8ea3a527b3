#pragma once
// Radiance by cell, in a hash table of fixed size whose content does not depend on the order in which it was filled.
//
// A key has one bucket of kSlots places. New keys of a round are put into what is free of it by a cascade: at each
// place the greater fingerprint stays and the lesser goes on to the next, so that the greatest are there in descending
// order, whoever came first; what finds no place is refused, and its samples with it. Older cells are never moved by
// that; of a full bucket those go that have had no sample for kMostAge rounds. [Shun and Blelloch 2014]
// Phase-Concurrent Hash Tables for Determinism.
//
// Sums are whole numbers of a unit, which add up to the same whatever the order. What a sample is beyond whole units is
// rounded up with as much probability: to truncate would darken, by half a unit a sample.

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/core/rgb.h"
#include "renderer/methods/radiance_cache/cell_grid.h"

namespace photond {

struct AgedCells;

/// What one vertex of a path found. `radiance` is finite and not negative; `random`: of its own.
struct CellSample {
    CellKey key;
    Rgb radiance;
    uint32_t random;
};

class RadianceCells {
public:
    static constexpr uint32_t kSlots = 8;  // of a bucket
    static constexpr uint32_t kMostAge =
        4;  // rounds without a sample, after which a cell may go where another needs room
    static constexpr uint32_t kLeastCells = kSlots;
    /// A sample counts as at most so many units: 2^20 times the mean of those it began with.
    static constexpr float kMostUnits = 0x1p40f;
    static constexpr float kUnitsOfMean = 0x1p20f;

    /// Room for at least that many cells, at most twice as many.
    explicit RadianceCells(uint32_t cells);
    static uint64_t bytes_for(uint32_t cells);
    static uint32_t buckets_for(uint32_t cells);  // a power of two

    /// Forgets all.
    void clear();
    /// After clear(): cells of the frame before.
    void begin_with(const AgedCells& aged);
    /// A round: adds lists of samples, in parallel. The first after clear() says what a unit is: 2^-20 of their mean.
    void add(std::span<const std::vector<CellSample>> lists);

    struct Mean {
        Rgb radiance{0};
        uint32_t samples = 0;  // 0: there is no such cell
    };
    /// Of all samples of the cell so far. Not to be asked while add() runs.
    Mean find(const CellKey& key) const;

    /// Calls visit(slot, fingerprint, mean, last_round) for each cell, in the order of places.
    template <class Visit>
    void for_each(const Visit& visit) const {
        for (uint32_t slot = 0; slot < fingerprints_.size(); ++slot)
            if (const uint32_t fingerprint = fingerprints_[slot].load(std::memory_order_relaxed))
                visit(slot, fingerprint, mean_of(sums_[slot]), sums_[slot].last_round);
    }

    uint64_t cells() const;                        // that there are
    uint64_t refused() const { return refused_; }  // samples, for want of room, since clear()
    uint64_t evicted() const { return evicted_; }  // cells, since clear()
    double unit() const { return unit_; }          // of the sums

private:
    struct Sums {
        std::atomic<uint64_t> radiance[3];
        std::atomic<uint32_t> samples;
        uint32_t last_round;  // with a sample; 64 bits beside `samples`
    };
    static constexpr uint32_t kNoSlot = ~0u;

    uint32_t bucket_of(const CellKey& key) const { return key.place & (buckets_ - 1); }
    uint32_t slot_of(const CellKey& key) const;
    Mean mean_of(const Sums& sums) const;
    void make_room(uint32_t bucket, std::atomic<uint64_t>& evicted);
    void insert(const CellKey& key);
    bool add(const CellSample& sample);

    uint32_t buckets_;  // a power of two
    uint32_t round_ = 0;
    double unit_ = 0;
    uint64_t refused_ = 0, evicted_ = 0;
    std::vector<std::atomic<uint32_t>> fingerprints_;  // by slot; 0: free
    std::vector<Sums> sums_;
    std::vector<uint8_t> older_;  // by bucket: cells that were there when the round began, in its first slots
};

}  // namespace photond
