#include "renderer/backends/gpu/device_tiles.h"

#include <algorithm>

namespace photond::gpu {

namespace {

using uint = uint32_t;
#include "renderer/backends/gpu/device_tiles_shared.h"
static_assert(sizeof(DeviceTilesState) == 20 && sizeof(DeviceTilesConstants) == 16);

constexpr uint32_t kMostElements = 1u << 31;  // indices of a last, partly filled tile still fit 32 bits

}  // namespace

DeviceTiles::DeviceTiles(Device& device, const std::string& structure, uint32_t capacity, uint32_t tile)
    : capacity_(capacity),
      tile_(tile),
      row_groups_(std::min(device.limits().workgroups[0], 1u << 15)),
      pipeline_(device, "renderer/backends/gpu/device_tiles.comp", sizeof(DeviceTilesConstants)),
      state_(device, structure, sizeof(DeviceTilesState)) {
    if (capacity > kMostElements || groups(most_tiles(), row_groups_) > device.limits().workgroups[1])
        throw Error(ErrorCode::OutOfMemory, structure + " for " + std::to_string(capacity) +
                                                " elements: more than one dispatch on " + device.report().name +
                                                " can take");
}

void DeviceTiles::record(CommandList& commands, DeviceWord count) {
    commands.bind(pipeline_, {read("counts", *count.buffer), write("state", state_)});
    commands.push(DeviceTilesConstants{count.index, capacity_, tile_, row_groups_});
    commands.dispatch(1);
}

}  // namespace photond::gpu
