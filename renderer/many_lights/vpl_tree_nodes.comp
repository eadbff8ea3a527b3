#version 460
// VPL_TREE_GROUP nodes of a level side by side, and those above them up to the one that holds them all. Of level 0, the
// leaves are made here.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/many_lights/vpl_tree.glsl"

layout(local_size_x = VPL_TREE_GROUP) in;
layout(push_constant, scalar) uniform Push { VplTreePush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Counts { uint counts[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Vpls { Vpl vpls[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Lights { uint lights[]; };
layout(set = 0, binding = 3, scalar) buffer Nodes { VplTreeNode nodes[]; };

shared VplTreeNode below[VPL_TREE_GROUP];

void main() {
    const uint place = flat_index(), thread = gl_LocalInvocationIndex;
    const uint count = min(counts[push.count_word], push.most);
    uint level_nodes = vpl_tree_leaves(count) >> push.level;  // 0 above the root
    VplTreeNode node = VPL_TREE_NOTHING;
    if (place < level_nodes) {
        if (push.level > 0u) {
            node = nodes[level_nodes + place];
        } else {
            if (place < count) node = vpl_leaf(vpls[lights[place]], lights[place]);
            nodes[level_nodes + place] = node;
        }
    }
    below[thread] = node;
    for (uint width = VPL_TREE_GROUP / 2; width > 0u; width /= 2) {
        level_nodes /= 2;
        barrier();
        if (thread < width) node = merge_vpl_nodes(below[2 * thread], below[2 * thread + 1]);
        barrier();
        const uint above = place / VPL_TREE_GROUP * width + thread;
        if (thread < width) {
            below[thread] = node;
            if (above < level_nodes) nodes[level_nodes + above] = node;
        }
    }
}
