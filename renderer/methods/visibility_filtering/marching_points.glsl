// The pixels that have a list of what they see: one in each block, that which lights itself too. Define VISIBILITY (the
// VisibilityConstants) before.
#ifndef PHOTOND_MARCHING_POINTS_GLSL
#define PHOTOND_MARCHING_POINTS_GLSL

#include "renderer/gbuffer/gbuffer_point.glsl"
#include "renderer/gbuffer/split_buffer.glsl"
#include "renderer/methods/visibility_filtering/visibility_lists_shared.h"

/// Where a block's is, along either axis.
uint marching_offset() {
    const uint side = VISIBILITY.march_side, lit_side = VISIBILITY.split.side;
    return lit_side / 2u + (side > lit_side ? side / 2u : 0u);
}
/// Its place in the split buffer.
uint marching_point(uint list) {
    const SplitRecord split = VISIBILITY.split;
    const uint x = list % VISIBILITY.march_columns * VISIBILITY.march_side + marching_offset();
    const uint y = list / VISIBILITY.march_columns * VISIBILITY.march_side + marching_offset();
    return split_point_of(split, min(x, split.width - 1u), min(y, split.height - 1u));
}

/// The normal on the side of a surface that a ray leaves to.
vec3 side_towards(GBufferPoint point, vec3 direction) {
    return dot(direction, point.geometric_normal) < 0.0 ? -point.geometric_normal : point.geometric_normal;
}

/// How far the points are from the first one's plane may be, or little more [m].
float agreeing_height_m(GBufferPoint point) { return VISIBILITY.filter_distance * max(point.depth_m, 1e-6); }

#endif
