#include "renderer/backends/gpu/group_sum.h"

#include <algorithm>

namespace photond::gpu {

GroupShape::GroupShape(const Device& device, uint32_t wanted) {
    const uint32_t subgroup = device.limits().subgroup_size;
    warp = wanted > 0 ? wanted : std::min(subgroup, 32u);
    if (warp > 32 || (warp & (warp - 1)) != 0 || threads() > device.limits().workgroup_size)
        throw Error(ErrorCode::Internal, "groups cannot be made of warps of " + std::to_string(warp) + " threads");
    in_subgroups = subgroup % warp == 0;
}

}  // namespace photond::gpu
