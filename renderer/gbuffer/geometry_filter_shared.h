// Settings of the geometry-aware filter, for both compilers.
#ifndef PHOTOND_GEOMETRY_FILTER_SHARED_H
#define PHOTOND_GEOMETRY_FILTER_SHARED_H

#ifdef __cplusplus
#include <cstdint>

namespace photond::gpu {
using uint = uint32_t;
#endif

struct GeometryFilter {
    uint width;               // pixels across, 1 to 32; a multiple of SplitLayout::side takes each subset alike
    float normal_cosine;      // least, of the angle between the normals that shade
    float distance_relative;  // greatest, to the pixel's tangent plane, over the pixel's depth
};

#ifdef __cplusplus
static_assert(sizeof(GeometryFilter) == 12, "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
