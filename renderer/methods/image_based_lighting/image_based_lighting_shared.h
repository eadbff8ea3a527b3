// The shader of image-based lighting, for both compilers.
#ifndef PHOTOND_IMAGE_BASED_LIGHTING_SHARED_H
#define PHOTOND_IMAGE_BASED_LIGHTING_SHARED_H

#ifdef __cplusplus
#include <cstdint>

namespace photond::gpu {
using uint = uint32_t;
#endif

struct ImageBasedLightingPush {
    uint first_tile;  // of the image, a group each; half open
    uint end_tile;
};

#ifdef __cplusplus
}  // namespace photond::gpu
#endif

#endif
