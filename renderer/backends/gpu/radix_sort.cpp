#include "renderer/backends/gpu/radix_sort.h"

#include <algorithm>

namespace photond::gpu {

namespace {

using uint = uint32_t;
#include "renderer/backends/gpu/radix_sort_shared.h"
static_assert(sizeof(RadixSortConstants) == 8);

uint64_t bytes_of(uint64_t words) { return std::max<uint64_t>(words, 1) * sizeof(uint32_t); }

}  // namespace

RadixSort::RadixSort(Device& device, uint32_t capacity, uint32_t warp)
    : shape_(device, warp),
      tiles_(device, "radix sort counts", capacity, shape_.tile()),
      keys_(device, "radix sort keys", bytes_of(capacity)),
      values_(device, "radix sort values", bytes_of(capacity)),
      counts_(device, "radix sort counts", bytes_of(uint64_t{RADIX_MOST_DIGITS} * tiles_.most_tiles())),
      totals_(device, "radix sort counts", bytes_of(RADIX_MOST_DIGITS)),
      count_(device, "renderer/backends/gpu/radix_sort_count.comp", sizeof(RadixSortConstants), nullptr,
             shape_.constants()),
      rows_(device, "renderer/backends/gpu/prefix_sum_rows.comp", sizeof(uint32_t), nullptr, shape_.constants()),
      scatter_(device, "renderer/backends/gpu/radix_sort_scatter.comp", sizeof(RadixSortConstants), nullptr,
               shape_.constants()) {}

void RadixSort::record(CommandList& commands, Buffer& keys, Buffer& values, DeviceWord count, uint32_t key_bits) {
    if (key_bits < 1 || key_bits > 32)
        throw Error(ErrorCode::Internal, "keys of " + std::to_string(key_bits) + " bits cannot be sorted");
    tiles_.record(commands, count);
    // An even number of passes, so that the last one ends where the first began; as equal as they can be.
    const uint32_t passes = key_bits <= 16 ? 2 : 4;
    uint32_t shift = 0;
    for (uint32_t pass = 0; pass < passes; ++pass) {
        const uint32_t bits = (key_bits - shift + passes - pass - 1) / (passes - pass);
        const RadixSortConstants constants{shift, 1u << bits};
        const bool forth = pass % 2 == 0;
        Buffer &from_keys = forth ? keys : keys_, &to_keys = forth ? keys_ : keys;
        Buffer &from_values = forth ? values : values_, &to_values = forth ? values_ : values;
        commands.bind(count_, {read("tiles_state", tiles_.state()), read("keys", from_keys), write("counts", counts_)});
        commands.push(constants);
        tiles_.dispatch(commands);
        commands.bind(rows_,
                      {read("tiles_state", tiles_.state()), read_write("rows", counts_), write("totals", totals_)});
        commands.push(uint32_t{0});
        commands.dispatch(constants.digits);
        commands.bind(scatter_, {read("tiles_state", tiles_.state()), read("keys", from_keys),
                                 read("values", from_values), read("starts", counts_), read("totals", totals_),
                                 write("sorted_keys", to_keys), write("sorted_values", to_values)});
        commands.push(constants);
        tiles_.dispatch(commands);
        shift += bits;
    }
}

}  // namespace photond::gpu
