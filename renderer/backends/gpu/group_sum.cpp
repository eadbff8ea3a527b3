#include "renderer/backends/gpu/group_sum.h"

#include <algorithm>

namespace photond::gpu {

namespace {

constexpr uint32_t kSharedBytes = 20 << 10;  // a little more than the shaders' largest use

}  // namespace

GroupShape::GroupShape(const Device& device, uint32_t wanted) {
    const uint32_t subgroup = device.limits().subgroup_size;
    warp = wanted > 0 ? wanted : std::min(subgroup, 32u);
    if (warp > 32 || (warp & (warp - 1)) != 0 || threads() > device.limits().workgroup_size)
        throw Error(ErrorCode::Internal, "groups cannot be made of warps of " + std::to_string(warp) + " threads");
    if (device.limits().shared_memory < kSharedBytes)
        throw Error(ErrorCode::Unsupported,
                    device.report().name + " has " + std::to_string(device.limits().shared_memory) +
                        " bytes of shared memory; sums and sorts need " + std::to_string(kSharedBytes));
    in_subgroups = subgroup % warp == 0;
}

}  // namespace photond::gpu
