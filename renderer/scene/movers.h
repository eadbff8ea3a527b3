#pragma once
// What each animation of a rig moves, as counts: what clients choose one by.

#include <vector>

#include "renderer/scene/rig.h"

namespace photond {

struct Movers {
    uint32_t meshes = 0;
    uint64_t triangles = 0;  // of these meshes
    uint32_t cameras = 0, lights = 0, materials = 0;
};

/// Of each of the rig's animations. Takes time by what they move, all together: throws ErrorCode::BadScene where that
/// is more than `max_moved` nodes, meshes and joints. No sound file comes near so many.
std::vector<Movers> count_movers(const Rig& rig, uint64_t max_moved = 100'000'000);

}  // namespace photond
