// Writes a buffer, which vertex shaders may not.
#version 460
#extension GL_EXT_scalar_block_layout : require

layout(set = 0, binding = 0, scalar) buffer Count { uint vertices; };
layout(location = 0) out flat vec4 color;

void main() {
    vertices = 1;
    color = vec4(0);
    gl_Position = vec4(0);
}
