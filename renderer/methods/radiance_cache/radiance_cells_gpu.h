#pragma once
// RadianceCells on a device: the same table, whose content does not depend on the order in which it was filled.

#include <optional>

#include "renderer/backends/gpu/command_list.h"
#include "renderer/methods/radiance_cache/aged_cells.h"
#include "renderer/methods/radiance_cache/cell_grid.h"
#include "renderer/methods/radiance_cache/params.h"
#include "renderer/methods/radiance_cache/radiance_cache_shared.h"

namespace photond {

class RadianceCellsGpu {
public:
    /// Room for as many cells as RadianceCells has, and for the records of so many paths a round. `aged`: they go from
    /// frame to frame.
    RadianceCellsGpu(gpu::Device& device, uint32_t cells, uint32_t paths, bool aged);
    static uint64_t device_bytes(uint32_t cells, uint32_t paths, bool aged);

    /// What the table is to begin with each time; copied to the device.
    void begin_with(gpu::Device& device, const AgedCells& aged);
    /// Forgets all; from then on cells are the grid's. `key`: of their numbers.
    void record_clear(gpu::CommandList& commands, const CellGrid& grid, const RadianceCacheParams& params,
                      uint32_t key);
    /// The round before the first one.
    uint32_t first_round() const { return first_round_; }
    /// Adds what the paths have left in records(): a round of them, from first_round() + 1 on.
    void record_add(gpu::CommandList& commands, uint32_t paths, uint32_t round);
    /// The table goes to the host, for the frame after.
    void record_leave(gpu::CommandList& commands);
    /// Once that and record_counts() have been waited for.
    void leave(const CellsBetweenFrames& frames, LeftCells& left) const;
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
    /// A table beside the one in use.
    struct Table {
        gpu::Buffer fingerprints, sums;
    };

    const uint32_t buckets_;
    uint32_t first_round_ = 0;
    float brightest_ = 0;  // the state's, of what the table begins with
    std::optional<Table> aged_, host_;
    gpu::Buffer constants_, state_, host_state_, fingerprints_, sums_, older_, records_, record_counts_;
    gpu::ComputePipeline room_, insert_, add_;
};

}  // namespace photond
