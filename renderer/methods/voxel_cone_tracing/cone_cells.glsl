// Cells of a tree with light in it, by their place and size. They have the bindings 0 to 5 of set
// 0. Define CONE_CELLS_ACCESS before where the cells are not only read.
#ifndef PHOTOND_CONE_CELLS_GLSL
#define PHOTOND_CONE_CELLS_GLSL

#extension GL_EXT_scalar_block_layout : require

#include "renderer/core/geometry.glsl"
#include "renderer/methods/voxel_cone_tracing/cone_tree_shared.h"

#ifndef CONE_CELLS_ACCESS
#define CONE_CELLS_ACCESS readonly
#endif

layout(set = 0, binding = 0, scalar) readonly buffer SvoConstantsBuffer { SvoConstants svo_constants; };
layout(set = 0, binding = 1, scalar) readonly buffer SvoBricks { uvec2 svo_bricks[]; };
layout(set = 0, binding = 2, scalar) readonly buffer SvoSurfaces { uint svo_surfaces[]; };
layout(set = 0, binding = 3, scalar) readonly buffer ConeConstants { ConeTreeConstants cone_tree; };
layout(set = 0, binding = 4, scalar) readonly buffer ConeTable { uint cone_table[]; };
layout(set = 0, binding = 5, scalar) CONE_CELLS_ACCESS buffer ConeCells { ConeCell cone_cells[]; };

/// Where a level's cells begin in the table, x fastest: level 1 has two along an edge.
uint cone_table_first(uint level) { return ((1u << 3u * level) - 8u) / 7u; }

uint cone_table_at(uint level, ivec3 cell) {
    return cone_table[cone_table_first(level) + (uint(cell.x) | uint(cell.y) << level | uint(cell.z) << 2u * level)];
}

/// The place of a voxel among those of all bricks; NO_CONE_CELL: it is not set.
uint voxel_in_brick(uint brick, ivec3 voxel) {
    const uvec2 mask = svo_bricks[brick];
    const uint bit = uint((voxel.x & 3) | (voxel.y & 3) << 2 | (voxel.z & 3) << 4), below = (1u << (bit & 31u)) - 1u;
    if (((bit < 32u ? mask.x : mask.y) >> (bit & 31u) & 1u) == 0u) return NO_CONE_CELL;
    return svo_surfaces[brick] +
           (bit < 32u ? uint(bitCount(mask.x & below)) : uint(bitCount(mask.x) + bitCount(mask.y & below)));
}

/// The cell of 2^mip voxels along an edge that lies there; NO_CONE_CELL: nothing is in it.
uint cone_cell_at(int mip, ivec3 cell) {
    const int side = int(svo_constants.grid.resolution) >> mip;
    if (any(lessThan(cell, ivec3(0))) || any(greaterThanEqual(cell, ivec3(side)))) return NO_CONE_CELL;
    if (mip > 2) return cone_table_at(cone_tree.levels + 2u - uint(mip), cell);
    const uint brick_cell = cone_table_at(cone_tree.levels, cell >> (2 - mip));
    if (mip == 2 || brick_cell == NO_CONE_CELL) return brick_cell;
    const uint brick = brick_cell - cone_tree.first_brick;
    if (mip == 0) return voxel_in_brick(brick, cell);
    return cone_tree.first_half + 8u * brick + uint((cell.x & 1) | (cell.y & 1) << 1 | (cell.z & 1) << 2);
}

/// Three values not negative in 32 bits, of a common exponent: within 1/512 of the greatest. [Ward 1991] Real Pixels.
uint pack_shared_exponent(vec3 value) {
    const float greatest = max_component(value);
    if (!(greatest > 1e-36)) return 0u;
    const int exponent = clamp(int(floatBitsToUint(greatest) >> 23u) - 126, -110, 127);
    uvec3 mantissas = uvec3(value * exp2(float(8 - exponent)) + 0.5);
    mantissas = min(mantissas, uvec3(255u));
    return mantissas.x | mantissas.y << 8u | mantissas.z << 16u | uint(exponent + 128) << 24u;
}
vec3 unpack_shared_exponent(uint bits) {
    if (bits == 0u) return vec3(0.0);
    return vec3(bits & 0xffu, bits >> 8u & 0xffu, bits >> 16u & 0xffu) * exp2(float(int(bits >> 24u) - 136));
}

float cone_opacity(ConeCell cell, int axis) {
    return float(cell.opacity >> (OPACITY_BITS * uint(axis)) & OPACITY_MOST) / float(OPACITY_MOST);
}
uint pack_opacity(vec3 opacity) {
    const uvec3 parts = uvec3(clamp(opacity, 0.0, 1.0) * float(OPACITY_MOST) + 0.5);
    return parts.x | parts.y << OPACITY_BITS | parts.z << 2u * OPACITY_BITS;
}

#endif
