// What the passes that build an octree work by: the state of the build, of set 0, binding 0.
#ifndef PHOTOND_SVO_BUILD_GLSL
#define PHOTOND_SVO_BUILD_GLSL

#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/voxels/svo_build_shared.h"

layout(set = 0, binding = 0, scalar) coherent buffer State { SvoBuildState state; };

/// Whether there is too little room for the tree's arrays but the surfaces, of which svo_surfaces.comp tells.
bool is_short(SvoBuildPush push) {
    return state.fragments > push.fragment_capacity || state.nodes > push.node_capacity ||
           state.bricks > push.brick_capacity;
}

uint groups_of(uint elements, uint group) { return elements / group + (elements % group > 0u ? 1u : 0u); }

/// The size of an indirect dispatch with at least so many groups.
uint[3] rows_of_groups(uint groups) {
    const uint row = 1u << 15;
    return uint[3](min(groups, row), groups_of(groups, row), 1u);
}

#endif
