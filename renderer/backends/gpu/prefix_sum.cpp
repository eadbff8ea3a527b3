#include "renderer/backends/gpu/prefix_sum.h"

#include <algorithm>

namespace photond::gpu {

PrefixSum::PrefixSum(Device& device, uint32_t capacity, uint32_t warp)
    : shape_(device, warp),
      tiles_(device, "prefix sum", capacity, shape_.tile()),
      tile_sums_(device, "prefix sum", std::max<uint64_t>(tiles_.most_tiles(), 1) * sizeof(uint32_t)),
      reduce_(device, "renderer/backends/gpu/prefix_sum_reduce.comp", 0, nullptr, shape_.constants()),
      rows_(device, "renderer/backends/gpu/prefix_sum_rows.comp", sizeof(uint32_t), nullptr, shape_.constants()),
      scan_(device, "renderer/backends/gpu/prefix_sum_scan.comp", 0, nullptr, shape_.constants()) {}

void PrefixSum::record(CommandList& commands, Buffer& words, Buffer& sums, DeviceWord count, DeviceWord total) {
    tiles_.record(commands, count);
    commands.bind(reduce_, {read("tiles_state", tiles_.state()), read("words", words), write("tile_sums", tile_sums_)});
    tiles_.dispatch(commands);
    commands.bind(
        rows_, {read("tiles_state", tiles_.state()), read_write("rows", tile_sums_), write("totals", *total.buffer)});
    commands.push(total.index);
    commands.dispatch(1);
    commands.bind(scan_, {read("tiles_state", tiles_.state()), read("words", words), read("tile_starts", tile_sums_),
                          write("sums", sums)});
    tiles_.dispatch(commands);
}

}  // namespace photond::gpu
