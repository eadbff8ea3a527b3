#pragma once
// The workgroups of prefix_sum.h and radix_sort.h, fitted to a device.

#include <array>

#include "renderer/backends/gpu/group_sum_shared.h"
#include "renderer/backends/gpu/pipeline.h"

namespace photond::gpu {

/// Groups of WARPS warps (group_sum.glsl).
struct GroupShape {
    /// `warp`: threads, a power of two up to 32; 0: as many as the device's subgroups have. Others than those are right
    /// as well, and slower. Throws ErrorCode::Internal for one that is none, ErrorCode::Unsupported where groups
    /// have less than 20 KiB of shared memory.
    explicit GroupShape(const Device& device, uint32_t warp = 0);

    uint32_t warp = 0;
    bool in_subgroups = false;  // a subgroup holds whole warps
    uint32_t threads() const { return WARPS * warp; }
    uint32_t tile() const { return threads() * TILE_ITEMS; }
    std::array<Specialization, 3> constants() const {
        return {specialize(GROUP_SIZE_CONSTANT, threads()), specialize(WARP_CONSTANT, warp),
                specialize(WARPS_IN_SUBGROUPS_CONSTANT, in_subgroups)};
    }
};

}  // namespace photond::gpu
