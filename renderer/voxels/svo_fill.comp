#version 460
// The tree's nodes and bricks. The first threads, one for each node above the bricks that there could be, make the tiles
// of those that are flagged (thesis, 4.3.2, steps 6 and 8); then one a fragment adds its voxels to its brick. Where the
// tree follows from a kept one, svo_kept_tiles.comp was there before the first threads.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require

#include "renderer/voxels/svo_fragments.glsl"
#define SVO_NODES_BINDING 5
#include "renderer/voxels/svo_tiles.glsl"

layout(set = 0, binding = 6, scalar) buffer Bricks { SvoBrick bricks[]; };

void begin_brick(uint brick, uint word, uint bit) {}  // it is empty

/// Gives how many voxels are set that no other fragment has set.
uint add_voxels(SvoFragment fragment) {
    const uint brick = brick_of(fragment.brick);
    uint added = 0u;
    if (brick >= push.brick_capacity) return added;
    for (int word = 0; word < 2; ++word) {
        const uint mask = fragment.mask[word];
        if ((mask & ~bricks[brick].mask[word]) != 0u)
            added += uint(bitCount(mask & ~atomicOr(bricks[brick].mask[word], mask)));
    }
    return added;
}

void main() {
    const uint i = flat_index(), nodes_above = push.follows != 0u ? 0u : 32u * SVO_FIRST_WORD(push.levels);
    if (i < nodes_above) {
        make_tile(i / 32u, i % 32u);
        return;
    }
    if (i - nodes_above >= fragment_count()) return;
    const uint added = subgroupAdd(add_voxels(fragments[i - nodes_above]));
    if (subgroupElect() && added > 0u) atomicAdd(state.voxels, added);
}
