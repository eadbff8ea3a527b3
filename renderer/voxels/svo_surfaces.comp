#version 460
// Where each brick's triangles begin, by one thread a brick; then the least number of the triangles in each voxel, by one
// thread a fragment. Where the tree follows from a kept one, svo_kept_surfaces.comp was there before the first threads.
// The very first looks whether there is room for all.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/voxels/svo_fragments.glsl"
#include "renderer/voxels/svo_first_voxels.glsl"
#define SVO_NODES_BINDING 9
#include "renderer/voxels/svo_root.glsl"

void add_triangle(SvoFragment fragment) {
    const uint brick = brick_of(fragment.brick);
    if (brick >= push.brick_capacity) return;
    uint first = first_surface(brick);
    for (int word = 0; word < 2; ++word) {
        const uint mask = bricks[brick].mask[word];
        for (uint left = fragment.mask[word]; left != 0u; left &= left - 1u) {
            const uint at = first + uint(bitCount(mask & ((left & -left) - 1u)));
            if (at < surfaces.length() && surfaces[at] > fragment.triangle) atomicMin(surfaces[at], fragment.triangle);
        }
        first += uint(bitCount(mask));
    }
}

void main() {
    const uint i = flat_index(), bricks_here = push.follows != 0u ? 0u : brick_count();
    if (i == 0u && state.voxels > push.voxel_capacity) empty_root();
    if (i < bricks_here)
        surfaces[i] = first_voxel(i);
    else if (i - bricks_here < fragment_count())
        add_triangle(fragments[i - bricks_here]);
}
