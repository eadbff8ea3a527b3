// Triangles of a buffer, each of an instance in the colour of another buffer; the half of clip space where x + y * slope
// is below `clip` is cut away.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

layout(push_constant, scalar) uniform Push {
    float clip;
    float slope;
} push;
layout(set = 0, binding = 0, scalar) readonly buffer Corners { vec3 corners[]; };  // of instance i: [3 i ...]
layout(set = 0, binding = 1, scalar) readonly buffer Colors { vec4 colors[]; };    // of instance i
layout(location = 0) out flat vec4 color;
out float gl_ClipDistance[1];

void main() {
    const vec3 corner = corners[gl_InstanceIndex * 3 + gl_VertexIndex];
    gl_Position = vec4(corner, 1);
    gl_ClipDistance[0] = corner.x + corner.y * push.slope - push.clip;
    color = colors[gl_InstanceIndex];
}
