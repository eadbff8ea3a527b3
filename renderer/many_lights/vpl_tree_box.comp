#version 460
// The lights' box, as ordered_bits().
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/many_lights/vpl_tree.glsl"

layout(local_size_x = VPL_TREE_GROUP) in;
layout(push_constant, scalar) uniform Push { VplTreePush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Counts { uint counts[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Vpls { Vpl vpls[]; };
layout(set = 0, binding = 2, scalar) buffer State { uint state[VPL_TREE_STATE_WORDS]; };

void main() {
    const uint i = flat_index();
    if (i >= min(counts[push.count_word], push.most)) return;
    for (uint axis = 0; axis < 3u; ++axis) {
        const uint place = ordered_bits(vpls[i].position[axis]);
        const uint low = subgroupMin(place), high = subgroupMax(place);
        if (subgroupElect()) {
            atomicMin(state[VPL_TREE_LOW + axis], low);
            atomicMax(state[VPL_TREE_HIGH + axis], high);
        }
    }
}
