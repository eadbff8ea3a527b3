#version 460
// Depth maps of splats from the tiles of an atlas: CPU twin SplatDepthMaps::spread(). A thread a texel.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/methods/photon_splatting/splat_depth_shared.h"
#include "renderer/methods/photon_splatting/splat_shared.h"

layout(local_size_x = SPLAT_GROUP) in;
#include "renderer/backends/gpu/invocation.glsl"
layout(push_constant, scalar) uniform Push { SplatDepthPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Constants { SplatConstants constants; };
layout(set = 0, binding = 1, scalar) readonly buffer Splats { Splat splats[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Atlas { float atlas[]; };  // over the frusta's depths
layout(set = 0, binding = 3, scalar) writeonly buffer DepthMaps { float farthest_m[]; };

/// A line of numbers about a place: the one there, and its neighbours where they are on the line.
struct Three {
    float before;
    float here;
    float after;
};

/// The greatest of the i-th of `count` numbers and its neighbours, as greatest_of_three() has it. Beyond either end the
/// numbers go on by half the last step.
float greatest(Three line, uint i, uint count, float most_step) {
    if (i == 0) line.before = line.here + 0.5 * clamp(line.here - line.after, 0.0, most_step);
    if (i + 1 == count) line.after = line.here + 0.5 * clamp(line.here - line.before, 0.0, most_step);
    return max(max(line.before, line.here), line.after);
}

/// The same for a column of a row of a tile; the row begins at `first`.
float greatest_of_row(uint first, uint column, uint side, float depth, float most_step) {
    Three line;
    line.here = atlas[first + column] * depth;
    line.before = column > 0 ? atlas[first + column - 1] * depth : 0.0;
    line.after = column + 1 < side ? atlas[first + column + 1] * depth : 0.0;
    return greatest(line, column, side, most_step);
}

void main() {
    const uint side = constants.shadow_resolution, texels = side * side;
    const uint tile = flat_index() / texels, texel = flat_index() % texels, index = push.first_splat + tile;
    if (index >= push.end_splat || (splats[index].kind & SPLAT_KIND_MASK) != SPLAT_BEAM) return;
    const uint width = push.columns * side, row = texel / side, column = texel % side;
    const uint first = ((tile / push.columns * side + row) * push.columns + tile % push.columns) * side;
    const Splat splat = splats[index];
    const float depth = max(splat.far_m - splat.near_m, 1e-6 * splat.radius), texel_m = 2.0 * splat.radius / float(side);
    const float most_step = SPLAT_MOST_SLOPE * texel_m;
    Three rows;
    rows.here = greatest_of_row(first, column, side, depth, most_step);
    rows.before = row > 0 ? greatest_of_row(first - width, column, side, depth, most_step) : 0.0;
    rows.after = row + 1 < side ? greatest_of_row(first + width, column, side, depth, most_step) : 0.0;
    farthest_m[index * texels + texel] = greatest(rows, row, side, most_step) + texel_m;
}
