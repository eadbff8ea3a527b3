// The walk that fills a G-buffer on a device (gbuffer_gpu.h), for both compilers.
#ifndef PHOTOND_GBUFFER_WALK_SHARED_H
#define PHOTOND_GBUFFER_WALK_SHARED_H

#include "renderer/gbuffer/gbuffer_shared.h"
#include "renderer/gbuffer/geometry_filter_shared.h"
#include "renderer/gbuffer/split_shared.h"

#ifdef __cplusplus
namespace photond::gpu {
#endif

struct GBufferWalkPush {
    SplitRecord split;
    uint first_tile;  // of the image, EYE_TILE pixels a side, half open
    uint end_tile;
    float glossy_threshold;
};

struct GBufferFilterPush {
    SplitRecord split;
    GeometryFilter filter_settings;
};

/// Points, a thread each.
struct PointPush {
    uint first_point;
    uint end_point;
};

#ifdef __cplusplus
}  // namespace photond::gpu
#endif

#endif
