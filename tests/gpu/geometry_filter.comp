#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/gbuffer/gbuffer_shared.h"
#include "renderer/gbuffer/geometry_filter_shared.h"
#include "renderer/gbuffer/split_buffer.glsl"
#include "tests/gpu/twin.glsl"

struct Settings {
    SplitRecord split;
    GeometryFilter geometry_filter;
};
layout(set = 0, binding = 0, scalar) readonly buffer In { Settings settings; };
layout(set = 0, binding = 1, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Sums { vec3 sums[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer Out { vec3 filtered[]; };

#define FILTER_POINTS points
#define FILTER_IRRADIANCE sums
#include "renderer/gbuffer/geometry_filter.glsl"

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    filtered[i] = filter_geometry_aware(settings.split, settings.geometry_filter, i);
}
