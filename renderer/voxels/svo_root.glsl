// The root's children. Define SVO_NODES_BINDING (of set 0) before.
#ifndef PHOTOND_SVO_ROOT_GLSL
#define PHOTOND_SVO_ROOT_GLSL

#extension GL_EXT_scalar_block_layout : require

#include "renderer/voxels/svo_shared.h"

layout(set = 0, binding = SVO_NODES_BINDING, scalar) writeonly buffer Nodes { SvoNode nodes[]; };

/// Makes a tree of nothing, for where there is too little room: nobody is led to what is not there.
void empty_root() {
    for (uint child = 0u; child < 8u; ++child) nodes[child] = SvoNode(SVO_LEAF, SVO_NO_DATA, 0u, 0u);
}

#endif
