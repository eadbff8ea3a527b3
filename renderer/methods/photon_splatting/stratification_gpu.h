#pragma once
// stratify() on a device: the same grid, cells and random numbers.

#include <optional>

#include "renderer/backends/gpu/prefix_sum.h"
#include "renderer/backends/gpu/radix_sort.h"
#include "renderer/methods/photon_splatting/stratification.h"
#include "renderer/methods/photon_splatting/stratification_shared.h"

namespace photond {

/// One pass's sources at a time: the photons that stratify() chooses, in its order, with its powers to a rounding.
/// Sums have about 48 bits where it has 53, so that of a million choices one may be another photon of the cell.
///
/// Photons are sorted by the Morton codes of their cells (radix_sort.h; twice for grids of more than 1020 cells, whose
/// codes have more than 32 bits). The first of each block counts what the block holds; joined blocks are found without
/// going through levels one after another (stratify_join.comp). One thread goes through a cell: cells of 10^5 photons
/// and more, where a few voxels hold all, take as long as all others together.
/// lavapipe: a million photons in 64 or 256 cells a side in 0.5 to 0.8 s, the host in 0.7 to 0.8 s, all sources alike.
///
/// In the accounts as "stratification". Borrows its device.
class StratificationGpu {
public:
    StratificationGpu(gpu::Device& device, const StratificationSettings& settings);
    static uint64_t device_bytes(uint64_t photons, uint32_t minimum_photons);

    /// Makes room for a pass of so many photons. What was recorded before must have been waited for.
    void start(uint64_t seed, uint32_t pass, uint32_t photons);
    /// The pass's photon i is photons[order[i]], ReflectedPhotonRecords. Stage `stratify`.
    void record(gpu::CommandList& commands, gpu::Buffer& photons, gpu::Buffer& order);
    /// Once that has been waited for.
    uint32_t sources_of_pass() const { return host_state_.as<uint32_t>()[STRATIFICATION_SOURCES]; }

    gpu::Buffer& sources() { return sources_; }  // SplatSourceRecord
    gpu::Buffer& state() { return state_; }      // words, STRATIFICATION_PHOTONS ...

private:
    bool joins() const { return settings_.minimum_photons > 1; }
    void make_room(uint32_t photons);
    void record_sort(gpu::CommandList& commands, gpu::Buffer& photons, gpu::Buffer& order);

    gpu::Device& device_;
    const StratificationSettings settings_;
    const bool wide_;
    uint32_t capacity_ = 0;
    gpu::StratificationConstants push_{};
    gpu::Buffer state_, host_state_, keys_, places_, covers_, joined_, offsets_, sources_;
    gpu::ComputePipeline key_, join_, count_, choose_;
    std::optional<gpu::RadixSort> sort_;
    std::optional<gpu::PrefixSum> sum_;
};

}  // namespace photond
