// SplitLayout (split_buffer.h) as shaders have it.
#ifndef PHOTOND_SPLIT_SHARED_H
#define PHOTOND_SPLIT_SHARED_H

#define SPLIT_GROUP 64  // SplitLayout::kGroup
#define NO_PIXEL 0xffffffffu

#ifdef __cplusplus
#include "renderer/gbuffer/split_buffer.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

struct SplitRecord {
    uint width;  // of the image [pixels]
    uint height;
    uint side;
    uint tile_width;
    uint tile_height;
    uint tile_points;
};

#ifdef __cplusplus
static_assert(SPLIT_GROUP == SplitLayout::kGroup && NO_PIXEL == SplitLayout::kNoPixel);

inline SplitRecord device_record(const SplitLayout& layout) {
    return {layout.size.width, layout.size.height, layout.side,
            layout.tile_width, layout.tile_height, layout.tile_points};
}
}  // namespace photond::gpu
#endif

#endif
