// What is to be voxelised: triangles numbered one instance of a list after the other. Define SVO_ASKED_BINDING (of set 0)
// before.
#ifndef PHOTOND_SVO_ASKED_GLSL
#define PHOTOND_SVO_ASKED_GLSL

#extension GL_EXT_scalar_block_layout : require

#include "renderer/voxels/svo_build_shared.h"

layout(set = 0, binding = SVO_ASKED_BINDING, scalar) readonly buffer Asked { SvoAskedInstance asked[]; };

/// The instance of a triangle.
SvoAskedInstance asked_instance(uint number, uint count) {
    uint low = 0u, high = count;  // the last instance that begins at or before the number is in [low, high)
    while (high - low > 1u) {
        const uint middle = (low + high) / 2u;
        if (asked[middle].first <= number) low = middle; else high = middle;
    }
    return asked[low];
}

#endif
