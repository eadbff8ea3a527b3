#version 460
// The geometry-aware filter over the points of a G-buffer, a thread a point: filter_geometry_aware().
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/gbuffer/gbuffer_walk_shared.h"

layout(local_size_x = SPLIT_GROUP) in;
layout(push_constant, scalar) uniform Push { GBufferFilterPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Sums { vec3 sums[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Filtered { vec3 filtered[]; };

#define FILTER_POINTS points
#define FILTER_IRRADIANCE sums
#include "renderer/gbuffer/geometry_filter.glsl"

void main() {
    const uint index = flat_index();
    if (index < push.split.tile_points * push.split.side * push.split.side)
        filtered[index] = filter_geometry_aware(push.split, push.filter_settings, index);
}
