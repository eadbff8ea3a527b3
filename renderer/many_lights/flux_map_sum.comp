#version 460
// FluxMap::sum(): some levels of the pyramid at a time, each group's from four values a thread on. The same additions.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/core/geometry.glsl"
#include "renderer/many_lights/flux_map.glsl"

layout(local_size_x = FLUX_MAP_GROUP) in;
layout(push_constant, scalar) uniform Push { FluxLevelsPush push; };
layout(set = 0, binding = 0, scalar) buffer Sums { float sums[]; };

shared float values[FLUX_MAP_GROUP];

/// What no number, infinite or negative worth counts as; and the most that counts.
float sound_worth(float worth) { return worth > 0.0 && worth < INFINITY ? min(worth, 1e30) : 0.0; }

void main() {
    const uint index = flat_index(), lane = gl_LocalInvocationIndex;
    uint squares = 1u << (2u * (push.levels - push.from_level));  // of the level that is read
    float value = 0.0;
    if (index < squares / 4u) {
        const uint at = flux_level(push.levels, squares) + 4u * index;
        vec4 four = vec4(sums[at], sums[at + 1u], sums[at + 2u], sums[at + 3u]);
        if (push.from_level == 0) {
            for (int i = 0; i < 4; ++i) {
                four[i] = sound_worth(four[i]);
                sums[at + i] = four[i];
            }
        }
        value = (four.x + four.y) + (four.z + four.w);
    }
    uint mine = FLUX_MAP_GROUP;  // squares of the group at this level
    for (uint level = 1; level <= FLUX_MAP_GROUP_LEVELS; ++level, mine /= 4u) {
        squares /= 4u;
        if (squares == 0u) return;  // all groups at once
        if (lane < mine) {
            const uint square = (index / FLUX_MAP_GROUP) * mine + lane;
            if (square < squares) sums[flux_level(push.levels, squares) + square] = value;
            values[lane] = value;
        }
        barrier();
        if (lane < mine / 4u)
            value = (values[4u * lane] + values[4u * lane + 1u]) + (values[4u * lane + 2u] + values[4u * lane + 3u]);
        barrier();
    }
}
