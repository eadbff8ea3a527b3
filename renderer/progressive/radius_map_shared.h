// A map of radii as shaders have it: for both compilers. CPU twin: radius_map.h.
#ifndef PHOTOND_RADIUS_MAP_SHARED_H
#define PHOTOND_RADIUS_MAP_SHARED_H

#define RADIUS_MAP_LEAF 3u  // RadiusMapRecord::axis

#ifdef __cplusplus
#include <cstdint>
namespace photond::gpu {
using uint = uint32_t;
#endif

/// A node; of a leaf the words are its radius and its box's widths, all floats.
struct RadiusMapRecord {
    float plane;  // points left of it have coordinates below
    uint axis;    // RADIUS_MAP_LEAF: `left` is the number of a leaf
    uint left;
    uint right;
};

#ifdef __cplusplus
static_assert(sizeof(RadiusMapRecord) == 16);
}  // namespace photond::gpu
#endif

#endif
