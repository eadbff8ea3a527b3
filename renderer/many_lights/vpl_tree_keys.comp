#version 460
// Where each light comes along the curve.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/many_lights/vpl_tree.glsl"

layout(local_size_x = VPL_TREE_GROUP) in;
layout(push_constant, scalar) uniform Push { VplTreePush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Counts { uint counts[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Vpls { Vpl vpls[]; };
layout(set = 0, binding = 2, scalar) readonly buffer State { uint state[VPL_TREE_STATE_WORDS]; };
layout(set = 0, binding = 3, scalar) writeonly buffer Keys { uint keys[]; };
layout(set = 0, binding = 4, scalar) writeonly buffer Lights { uint lights[]; };

void main() {
    const uint i = flat_index();
    if (i >= min(counts[push.count_word], push.most)) return;
    vec3 low, high;
    for (uint axis = 0; axis < 3u; ++axis) {
        low[axis] = float_from_ordered(state[VPL_TREE_LOW + axis]);
        high[axis] = float_from_ordered(state[VPL_TREE_HIGH + axis]);
    }
    precise const vec3 extent = high - low;
    keys[i] = vpl_key(vpls[i], low, vpl_key_scale(extent));
    lights[i] = i;
}
