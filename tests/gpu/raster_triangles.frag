// A fragment's colour, and how many fragments there were.
#version 460
#extension GL_EXT_scalar_block_layout : require

layout(location = 0) in flat vec4 color;
layout(location = 0) out vec4 target;
layout(set = 0, binding = 2, scalar) buffer Count { uint fragments; };

void main() {
    atomicAdd(fragments, 1);
    target = color;
}
