// Depth maps of beams drawn into one atlas, for both compilers (splat_depth_atlas.h).
#ifndef PHOTOND_SPLAT_DEPTH_SHARED_H
#define PHOTOND_SPLAT_DEPTH_SHARED_H

#ifdef __cplusplus
#include <cstdint>
namespace photond::gpu {
using uint = uint32_t;
#endif

/// Splats of a batch, a tile of the atlas each; the first has the tile in the upper left.
struct SplatDepthPush {
    uint first_splat;
    uint end_splat;
    uint columns;  // of tiles
    uint rows;
};

#ifdef __cplusplus
}  // namespace photond::gpu
#endif

#endif
