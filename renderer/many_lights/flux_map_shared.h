// The pyramid over a map of texels, for both compilers. C++: flux_map.h, GLSL: flux_map.glsl.
#ifndef PHOTOND_FLUX_MAP_SHARED_H
#define PHOTOND_FLUX_MAP_SHARED_H

#define FLUX_MAP_MOST_LEVELS 10  // a side of 2^10
#define FLUX_MAP_GROUP 64        // threads; a power of 4
#define FLUX_MAP_GROUP_LEVELS 4  // that a group sums up: 4^4 texels, four to a thread

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

/// Of the kernel that sums the levels.
struct FluxLevelsPush {
    uint from_level;  // its values are there
    uint levels;      // of the map
};

#ifdef __cplusplus
}  // namespace photond::gpu
#endif

#endif
