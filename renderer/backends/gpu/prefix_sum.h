#pragma once
// Exclusive prefix sums of uints on the device.
//
// Reduce, then scan: the sum of every tile, exclusive sums of those by one group, then sums within the tiles. An
// element is read twice and written once: 12 bytes, and 3 additions. Three dispatches that depend on each other,
// whatever the length; no group waits for another that runs, which not every device promises to make progress with.
//
// [Blelloch 1990] Prefix Sums and Their Applications. Technical Report CMU-CS-90-190.

#include "renderer/backends/gpu/device_tiles.h"
#include "renderer/backends/gpu/group_sum.h"

namespace photond::gpu {

/// Borrows its device. One at a time of a sum's records may be under way: they share its scratch, 4 bytes a tile, which
/// the accounts call "prefix sum". Barriers between records follow by themselves.
class PrefixSum {
public:
    /// `capacity`: most elements, up to 2^31. `warp` as in GroupShape.
    PrefixSum(Device& device, uint32_t capacity, uint32_t warp = 0);

    /// sums[i] = words[0] + ... + words[i - 1] for i below the count (the capacity, if the count is more), and the sum
    /// of all to `total`; modulo 2^32. `sums` may be `words` itself; both hold at least that many uints. Words past the
    /// count stay as they are. The same bits every time.
    void record(CommandList& commands, Buffer& words, Buffer& sums, DeviceWord count, DeviceWord total);

private:
    const GroupShape shape_;
    DeviceTiles tiles_;
    Buffer tile_sums_;
    ComputePipeline reduce_, rows_, scan_;
};

}  // namespace photond::gpu
