#pragma once
// Sorting uint keys with uint values on the device, stably.
//
// By digits of up to 8 bits from the lowest, two passes or four: each counts the digits of every tile, sums the counts,
// and puts the tile's elements where they go. A pass reads an element's key twice and its value once, writes both, and
// moves 256 counts a tile four times: 21 bytes an element on devices with subgroups of 32 or more, so 42 for up to 16
// bits of key and 84 for more; 3 dispatches a pass, and one more. Each key costs a shared-memory atomic to be counted
// and one to be ranked, with 3 barriers of its warp. No group waits for another that runs (prefix_sum.h), so devices
// without fair scheduling sort as well.
//
// [Merrill and Grimshaw 2011] High Performance and Scalable Radix Sorting: A Case Study of Implementing Dynamic
// Parallelism for GPU Computing. Parallel Processing Letters 21(2). Ranking by a warp's matching bits: [Ashkiani et al.
// 2016] GPU Multisplit. PPoPP, and [Adinets and Merrill 2022] Onesweep: A Faster Least Significant Digit Radix Sort for
// GPUs. arXiv:2206.01784.

#include "renderer/backends/gpu/device_tiles.h"
#include "renderer/backends/gpu/group_sum.h"

namespace photond::gpu {

/// Borrows its device. One at a time of a sort's records may be under way: they share its scratch. In the accounts:
/// "radix sort keys" and "radix sort values", 4 bytes an element of the capacity each, and "radix sort counts", 1 KiB a
/// tile (4096 elements where subgroups have 32 threads) and a little. Barriers between records follow by themselves.
class RadixSort {
public:
    /// `capacity`: most elements, up to 2^31; the device's largest storage buffer bounds it too. `warp` as in
    /// GroupShape.
    RadixSort(Device& device, uint32_t capacity, uint32_t warp = 0);

    /// Sorts the first `count` elements (the capacity, if the count is more) by the lowest `key_bits` bits of their
    /// keys, 1 to 32; those whose bits are equal keep their order. Keys and values hold at least that many uints; what
    /// is past the count stays as it is. The same bits every time. Throws ErrorCode::Internal for other key_bits.
    void record(CommandList& commands, Buffer& keys, Buffer& values, DeviceWord count, uint32_t key_bits);

private:
    const GroupShape shape_;
    DeviceTiles tiles_;
    Buffer keys_, values_, counts_, totals_;
    ComputePipeline count_, rows_, scatter_;
};

}  // namespace photond::gpu
