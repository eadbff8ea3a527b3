#pragma once
// RadianceCells on a device: the same table, whose content does not depend on the order in which it was filled.

#include "renderer/backends/gpu/command_list.h"
#include "renderer/methods/radiance_cache/cell_grid.h"
#include "renderer/methods/radiance_cache/params.h"
#include "renderer/methods/radiance_cache/radiance_cache_shared.h"

namespace photond {

class RadianceCellsGpu {
public:
    /// Room for as many cells as RadianceCells has, and for the records of so many paths a round.
    RadianceCellsGpu(gpu::Device& device, uint32_t cells, uint32_t paths);
    static uint64_t device_bytes(uint32_t cells, uint32_t paths);

    /// Forgets all; from then on cells are the grid's. `key`: of their numbers.
    void record_clear(gpu::CommandList& commands, const CellGrid& grid, const RadianceCacheParams& params,
                      uint32_t key);
    /// Adds what the paths have left in records(): a round of them, from 1 on.
    void record_add(gpu::CommandList& commands, uint32_t paths, uint32_t round);
    /// Other numbers for those who ask.
    void record_key(gpu::CommandList& commands, uint32_t key);
    /// Counts begin at 0; and go to the host.
    void record_counts_clear(gpu::CommandList& commands);
    void record_counts(gpu::CommandList& commands);
    /// Once that has been waited for: CACHE_REFUSED, CACHE_HITS, CACHE_MISSES.
    uint64_t counted(uint32_t word) const;

    /// What radiance_cells.glsl asks for.
    void append_to(std::vector<gpu::Binding>& bindings);
    gpu::Buffer& records() { return records_; }              // CacheRecord, CACHE_MOST_RECORDS a path
    gpu::Buffer& record_counts() { return record_counts_; }  // uint, by path

private:
    const uint32_t buckets_;
    gpu::Buffer constants_, state_, host_state_, fingerprints_, sums_, older_, records_, record_counts_;
    gpu::ComputePipeline room_, insert_, add_;
};

}  // namespace photond
