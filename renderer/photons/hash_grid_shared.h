// A grid of cells with points sorted by cell, on the device: for both compilers. CPU twin: hash_grid.h.
#ifndef PHOTOND_HASH_GRID_SHARED_H
#define PHOTOND_HASH_GRID_SHARED_H

#define HASH_GRID_GROUP 256  // threads

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
using ivec3 = glm::ivec3;
#endif

/// Where cells lie, and where the grid's parts begin in arrays that several grids share.
struct HashGridConstants {
    vec3 origin;
    float cell_m;  // what cells are cut by: a search of that radius touches two rows of cells along either axis
    vec3 cells_per_m;
    uint hashed;  // rows begin at hashed places of the table; 0: each cell has an entry of its own
    ivec3 cells;
    uint slots;        // a power of two where hashed
    uint first_start;  // of `slots` + 1 that say where a slot's points begin, counted from first_point
    uint first_point;
    uint capacity;  // points there is room for
};

#ifdef __cplusplus
static_assert(sizeof(HashGridConstants) == 60);
}  // namespace photond::gpu
#endif

#endif
