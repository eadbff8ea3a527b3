// For both compilers.
#ifndef PHOTOND_PATH_TRACING_SHARED_H
#define PHOTOND_PATH_TRACING_SHARED_H

#ifdef __cplusplus
#include <cstdint>

namespace photond::gpu {
using uint = uint32_t;
#endif

/// A stretch of the film's tiles (pixel_of_tile() in eye_scene.glsl), a group each.
struct PathTracingPush {
    uint first_tile;
    uint end_tile;
};

#ifdef __cplusplus
}  // namespace photond::gpu
#endif

#endif
