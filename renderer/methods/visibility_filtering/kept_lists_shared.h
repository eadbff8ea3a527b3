// Lists of voxels that points take over from the frame before, for both compilers (kept_lists_gpu.h).
#ifndef PHOTOND_KEPT_LISTS_SHARED_H
#define PHOTOND_KEPT_LISTS_SHARED_H

#include "renderer/scene/camera_shared.h"

#define KEEPS_LISTS_ID 107  // a specialisation constant
#define KEPT_MOST_LISTS 16  // of a point, beside its own
#define KEPT_MOST_BOXES 64
#define NO_LIST 0xffffffffu

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

/// A point as its frame leaves it.
struct KeptPoint {
    vec3 position;  // world [m]
    vec3 normal;    // geometric
    uint lists;     // that it leaves: its own, and those that it took over
    uint instance;  // whose surface it lies on
};
#define KEPT_POINT_WORDS 8

/// A point, and what it takes over.
struct TakingPoint {
    KeptPoint now;
    uint from;   // the point of the frame before; NO_LIST: none
    uint taken;  // lists of it
};

/// About what has moved since, as it is or as it was.
struct MovedBox {
    vec3 low;
    vec3 high;
};

/// What the frame before was seen by, and what has moved since. Its points, and the places that their rays met, by
/// point, list and ray, are in words of one buffer: shaders may bind no more.
struct KeptConstants {
    CameraConstants camera;
    uint points;
    uint most_lists;  // that a point takes over
    uint boxes;
    MovedBox moved[KEPT_MOST_BOXES];
};

#ifdef __cplusplus
static_assert(sizeof(KeptPoint) == 4 * KEPT_POINT_WORDS && sizeof(TakingPoint) == 40,
              "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
