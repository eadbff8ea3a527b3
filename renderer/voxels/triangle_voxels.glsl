// GLSL twin of voxels/triangle_voxels.h: which voxels a triangle touches, exactly.
#ifndef PHOTOND_TRIANGLE_VOXELS_GLSL
#define PHOTOND_TRIANGLE_VOXELS_GLSL

#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

#include "renderer/voxels/voxel_grid.glsl"

const int VOXEL_SIZE_LOG2 = 8, BRICK_SIZE_LOG2 = 10;
const int VOXEL_SIZE = 1 << VOXEL_SIZE_LOG2, BRICK_SIZE = 1 << BRICK_SIZE_LOG2;

/// Coordinates of the first and the last box of that size whose widened extent touches [low, high].
int first_box(int low, int size_log2) { return (low - VOXEL_WIDEN - 1) >> size_log2; }
int last_box(int high, int size_log2) { return (high + VOXEL_WIDEN) >> size_log2; }

int64_t floor_div(int64_t a, int64_t b) {  // b > 0
    const int64_t quotient = a / b;
    return quotient - (quotient * b > a ? int64_t(1) : int64_t(0));
}
int64_t plus_part(int64_t x) { return max(x, int64_t(0)); }
int64_t minus_part(int64_t x) { return min(x, int64_t(0)); }

/// An edge's normal in a plane, and where the triangle lies along it, to be held against the least corner of a square.
struct EdgeSpan {
    i64vec2 n;
    int64_t low, high;
};
EdgeSpan edge_span(ivec2 a, ivec2 b, ivec2 c, int64_t side) {
    EdgeSpan span;
    span.n = i64vec2(a.y - b.y, b.x - a.x);
    const int64_t edge = span.n.x * int64_t(a.x) + span.n.y * int64_t(a.y);
    const int64_t corner = span.n.x * int64_t(c.x) + span.n.y * int64_t(c.y);
    span.low = min(edge, corner) - side * (plus_part(span.n.x) + plus_part(span.n.y));
    span.high = max(edge, corner) - side * (minus_part(span.n.x) + minus_part(span.n.y));
    return span;
}

/// A triangle ready to be asked about boxes.
struct TriangleVoxels {
    ivec3 p[3];
    ivec3 low, high;     // its box
    i64vec3 normal;      // 0 where it has none
    int64_t offset;      // normal . p on the triangle
    ivec3 first_brick;   // that its box touches
    ivec3 end_brick;
    int axis;            // of the columns of bricks it is visited by
};

TriangleVoxels make_triangle_voxels(QuantisedTriangle triangle, int bricks) {
    TriangleVoxels t;
    t.p = triangle.p;
    t.low = min(min(t.p[0], t.p[1]), t.p[2]);
    t.high = max(max(t.p[0], t.p[1]), t.p[2]);
    const i64vec3 a = i64vec3(t.p[1] - t.p[0]), b = i64vec3(t.p[2] - t.p[0]), p = i64vec3(t.p[0]);
    t.normal = a.yzx * b.zxy - a.zxy * b.yzx;
    t.offset = t.normal.x * p.x + t.normal.y * p.y + t.normal.z * p.z;
    for (int i = 0; i < 3; ++i) {
        t.first_brick[i] = max(first_box(t.low[i], BRICK_SIZE_LOG2), 0);
        t.end_brick[i] = min(last_box(t.high[i], BRICK_SIZE_LOG2) + 1, bricks);
    }
    const bool has_normal = t.normal.x != int64_t(0) || t.normal.y != int64_t(0) || t.normal.z != int64_t(0);
    const i64vec3 weight = has_normal ? abs(t.normal) : -i64vec3(t.high - t.low);
    t.axis = 0;
    int64_t most = weight.x;
    if (weight.y > most) t.axis = 1, most = weight.y;
    if (weight.z > most) t.axis = 2;
    return t;
}

/// Bricks of its box along axis + 1 and axis + 2.
ivec2 triangle_rows(TriangleVoxels t) {
    const ivec3 size = max(t.end_brick - t.first_brick, 0);
    return t.axis == 0 ? size.yz : t.axis == 1 ? size.zx : size.xy;
}
uint triangle_columns(TriangleVoxels t) {
    const ivec2 rows = triangle_rows(t);
    return min(t.end_brick.x - t.first_brick.x, min(t.end_brick.y - t.first_brick.y, t.end_brick.z - t.first_brick.z)) > 0
               ? uint(rows.x) * uint(rows.y) : 0u;
}

/// Turns the components cyclically so that `axis` comes last.
ivec3 axis_last(ivec3 v, int axis) { return axis == 0 ? v.yzx : axis == 1 ? v.zxy : v; }
i64vec3 axis_last(i64vec3 v, int axis) { return axis == 0 ? v.yzx : axis == 1 ? v.zxy : v; }
/// Undoes axis_last().
ivec3 axis_back(ivec3 v, int axis) { return axis == 0 ? v.zxy : axis == 1 ? v.yzx : v; }

/// Half-open range along the axis of a column's bricks that may be touched; `brick`: their coordinates, axis last.
ivec2 triangle_column(TriangleVoxels t, uint index, out ivec3 brick) {
    const ivec3 first = axis_last(t.first_brick, t.axis), end = axis_last(t.end_brick, t.axis);
    const uint row = uint(triangle_rows(t).x);
    brick = ivec3(first.x + int(index % row), first.y + int(index / row), 0);
    const int64_t side = int64_t(BRICK_SIZE + 2 * VOXEL_WIDEN);
    const ivec2 low = brick.xy * BRICK_SIZE - VOXEL_WIDEN;
    const ivec2 a = axis_last(t.p[0], t.axis).xy, b = axis_last(t.p[1], t.axis).xy, c = axis_last(t.p[2], t.axis).xy;
    for (int i = 0; i < 3; ++i) {
        const EdgeSpan edge = i == 0 ? edge_span(a, b, c, side) : i == 1 ? edge_span(b, c, a, side)
                                                                         : edge_span(c, a, b, side);
        const int64_t corner = edge.n.x * int64_t(low.x) + edge.n.y * int64_t(low.y);
        if (corner < edge.low || corner > edge.high) return ivec2(0);
    }
    ivec2 range = ivec2(first.z, end.z);
    i64vec3 n = axis_last(t.normal, t.axis);
    if (n.z != int64_t(0)) {
        // Where the plane passes through the column.
        int64_t rest = t.offset;
        if (n.z < int64_t(0)) n = -n, rest = -rest;
        rest -= n.x * int64_t(low.x) + n.y * int64_t(low.y);
        const int64_t least = rest - side * (plus_part(n.x) + plus_part(n.y));
        const int64_t most = rest - side * (minus_part(n.x) + minus_part(n.y));
        const int64_t kFar = int64_t(1 << 24);
        range.x = max(range.x, first_box(int(clamp(floor_div(least, n.z), -kFar, kFar)), BRICK_SIZE_LOG2));
        range.y = min(range.y, last_box(int(clamp(floor_div(most, n.z) + int64_t(1), -kFar, kFar)), BRICK_SIZE_LOG2) + 1);
    }
    return range;
}

/// Bit i + 4 j for each square of the brick's, seen along an axis, that the triangle's shadow may meet.
uint triangle_square_mask(ivec2 a, ivec2 b, ivec2 c, ivec2 brick) {
    const ivec2 corner = brick * BRICK_SIZE - VOXEL_WIDEN;
    const int64_t side = int64_t(VOXEL_SIZE + 2 * VOXEL_WIDEN);
    uint mask = 0xffffu;
    for (int k = 0; k < 3; ++k) {
        const EdgeSpan edge = k == 0 ? edge_span(a, b, c, side) : k == 1 ? edge_span(b, c, a, side)
                                                                         : edge_span(c, a, b, side);
        const i64vec2 step = edge.n * int64_t(VOXEL_SIZE);
        int64_t at_row = edge.n.x * int64_t(corner.x) + edge.n.y * int64_t(corner.y);
        uint within = 0u;
        for (int j = 0; j < 4; ++j, at_row += step.y) {
            int64_t at = at_row;
            for (int i = 0; i < 4; ++i, at += step.x)
                if (at >= edge.low && at <= edge.high) within |= 1u << (i + 4 * j);
        }
        mask &= within;
    }
    return mask;
}

/// Bit x + 4 y + 16 z for each touched voxel of a brick, 32 a word.
uvec2 triangle_brick_mask(TriangleVoxels t, ivec3 brick) {
    uvec3 row;  // voxels of the brick that the triangle's box touches, along each axis
    for (int i = 0; i < 3; ++i) {
        const int first = max(first_box(t.low[i], VOXEL_SIZE_LOG2) - BRICK_SIDE * brick[i], 0);
        const int last = min(last_box(t.high[i], VOXEL_SIZE_LOG2) - BRICK_SIDE * brick[i], BRICK_SIDE - 1);
        if (first > last) return uvec2(0u);
        row[i] = (2u << last) - (1u << first);
    }
    const uint xy = triangle_square_mask(t.p[0].xy, t.p[1].xy, t.p[2].xy, brick.xy);
    const uint yz = triangle_square_mask(t.p[0].yz, t.p[1].yz, t.p[2].yz, brick.yz);
    const uint xz = triangle_square_mask(t.p[0].xz, t.p[1].xz, t.p[2].xz, brick.xz);
    uvec2 mask = uvec2(0u);
    for (int z = 0; z < BRICK_SIDE; ++z) {
        uint slice = 0u;
        for (int y = 0; y < BRICK_SIDE; ++y)
            if (((row.y >> y) & (yz >> (y + 4 * z)) & 1u) != 0u)
                slice |= (row.x & (xy >> (4 * y)) & (xz >> (4 * z)) & 0xfu) << (4 * y);
        if (((row.z >> z) & 1u) == 0u) slice = 0u;
        if (z < 2) mask.x |= slice << (16 * z); else mask.y |= slice << (16 * (z - 2));
    }
    const i64vec3 n = t.normal;
    if (n.x == int64_t(0) && n.y == int64_t(0) && n.z == int64_t(0)) return mask;

    const int64_t side = int64_t(VOXEL_SIZE + 2 * VOXEL_WIDEN);
    const int64_t low = t.offset - side * (plus_part(n.x) + plus_part(n.y) + plus_part(n.z));
    const int64_t high = t.offset - side * (minus_part(n.x) + minus_part(n.y) + minus_part(n.z));
    const i64vec3 corner = i64vec3(brick * BRICK_SIZE - VOXEL_WIDEN), step = n * int64_t(VOXEL_SIZE);
    const int64_t first = n.x * corner.x + n.y * corner.y + n.z * corner.z;
    for (int word = 0; word < 2; ++word) {
        for (uint left = mask[word]; left != 0u; left &= left - 1u) {
            const int bit = findLSB(left), place = bit + 32 * word;
            const int64_t at = first + step.x * int64_t(place & 3) + step.y * int64_t((place >> 2) & 3) +
                               step.z * int64_t(place >> 4);
            if (at < low || at > high) mask[word] &= ~(1u << bit);
        }
    }
    return mask;
}

#endif
