// Volumes that light propagates in, for both compilers (propagation_volumes.h, propagation_volumes_gpu.h).
#ifndef PHOTOND_PROPAGATION_SHARED_H
#define PHOTOND_PROPAGATION_SHARED_H

#define PROPAGATION_GROUP 64  // threads
#define PROPAGATION_MOST_CASCADES 4

// The geometry volume: points of a face of a cell, along either side of it, and a face's bits in its cell's word, which
// say how open it is.
#define FACE_POINTS_SIDE 4u
#define FACE_POINTS (FACE_POINTS_SIDE * FACE_POINTS_SIDE)
#define FACE_BITS 8u
#define FACE_MOST 127u  // the share of light that passes is that of this
#define FACE_OPEN 255u  // nothing at all stands between

#define NO_PROPAGATION_CELL 0xffffffffu

// A specialisation constant.
#define ASKS_CELLS_ID 101

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
using glm::uvec3;
using glm::vec4;
#endif

/// One cascade's grid. Cell (x, y, z) is x + cells.x (y + cells.y z) from the cascade's first; its low faces lie at the
/// same place among one more of each.
struct PropagationGrid {
    vec3 low;  // world [m]
    float cell_m;
    uvec3 cells;
    uint unused;  // the compilers differ in whether they would leave room here
};

/// All of them, from the coarsest, which has the whole scene in it, to the finest. Each has as many cells.
struct PropagationCascades {
    PropagationGrid grids[PROPAGATION_MOST_CASCADES];
    uint count;
    uint cells;  // of each
    uint faces;
};

/// The light that leaves a cell, by channel: intensity in the direction w is x + dot(yzw, w) [W/sr], which is spherical
/// harmonics of order 1 without their factors.
struct CellLight {
    vec4 red;
    vec4 green;
    vec4 blue;
};

/// Of volume_faces.comp: cells with their low faces, of all cascades; half open.
struct FacesPush {
    uint first;
    uint end;
};

/// Of volume_keys.comp and volume_inject.comp.
struct InjectionPush {
    uint cascade;
};

/// Of volume_propagate.comp.
struct PropagationPush {
    uint cascade;
    uint is_first;  // what lies in the volume from an earlier pass does not count
};

/// Of volume_light.comp.
struct VolumeLightPush {
    uint first_point;  // half open
    uint end_point;
    float glossy_threshold;
};

#ifdef __cplusplus
static_assert(sizeof(PropagationGrid) == 32 && sizeof(PropagationCascades) == 140 && sizeof(CellLight) == 48,
              "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
