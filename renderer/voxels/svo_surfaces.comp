#version 460
// Where each brick's triangles begin, by one thread a brick; then the least number of the triangles in each voxel, by one
// thread a fragment.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/voxels/svo_fragments.glsl"

layout(set = 0, binding = 5, scalar) readonly buffer Bricks { SvoBrick bricks[]; };
layout(set = 0, binding = 6, scalar) readonly buffer FirstVoxels { uint first_voxels[]; };
layout(set = 0, binding = 7, scalar) readonly buffer VoxelStarts { uint voxel_starts[]; };
layout(set = 0, binding = 8, scalar) buffer Surfaces { uint surfaces[]; };

uint first_voxel(uint brick) { return first_voxels[brick] + voxel_starts[brick / push.sum_group]; }

void add_triangle(SvoFragment fragment) {
    const uint brick = brick_of(fragment.brick);
    if (brick >= push.brick_capacity) return;
    uint first = push.surface_base + first_voxel(brick);
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
    const uint i = flat_index(), brick_count = min(state.bricks, push.brick_capacity);
    if (i < brick_count)
        surfaces[i] = first_voxel(i);
    else if (i - brick_count < fragment_count())
        add_triangle(fragments[i - brick_count]);
}
