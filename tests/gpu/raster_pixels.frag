// Where a fragment is, to a target of whole numbers.
#version 460

layout(location = 0) in flat vec4 color;
layout(location = 0) out uvec2 target;

void main() { target = uvec2(gl_FragCoord.xy) + uvec2(color.xy); }
