#version 460
// Flags the nodes of the level under way that fragments lie in (thesis, 4.3.2, step 5).
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define DEVICE_TILES_BINDING 0
#define SVO_BUILD_NODES_BINDING 2
#include "renderer/backends/gpu/device_tiles.glsl"
#include "renderer/voxels/svo_build.glsl"

layout(local_size_x = SVO_GROUP) in;
layout(push_constant, scalar) uniform Push { SvoBuildPush push; };
layout(set = 0, binding = 1, scalar) readonly buffer Fragments { SvoFragment fragments[]; };

void main() {
    const uint i = tile_index() * SVO_GROUP + gl_LocalInvocationIndex;
    if (i >= tiles_state.elements) return;
    const uint node = find_node(fragments[i].brick, push.level, push);
    if (node != SVO_NO_DATA && (nodes[node].info & SVO_FLAGGED) == 0u) atomicOr(nodes[node].info, SVO_FLAGGED);
}
