// Lists of voxels that points take over from the frame before, for both compilers (kept_lists_gpu.h).
#ifndef PHOTOND_KEPT_LISTS_SHARED_H
#define PHOTOND_KEPT_LISTS_SHARED_H

#include "renderer/scene/camera_shared.h"

#define KEEPS_LISTS_ID 107  // a specialisation constant
#define KEPT_MOST_LISTS 16  // of a point, beside its own
#define NO_LIST 0xffffffffu

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

/// A point as its frame leaves it.
struct KeptPoint {
    vec3 position;  // world [m]
    uint lists;     // that it leaves: its own, and those that it took over
    vec3 normal;    // geometric
    uint instance;  // whose surface it lies on
};

/// A point, and what it takes over.
struct TakingPoint {
    KeptPoint now;
    uint from;   // the point of the frame before; NO_LIST: none
    uint taken;  // lists of it
};

/// What the frame before was seen by.
struct KeptConstants {
    CameraConstants camera;
    uint most_lists;  // that a point takes over
};

#ifdef __cplusplus
static_assert(sizeof(KeptPoint) == 32 && sizeof(TakingPoint) == 40, "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
