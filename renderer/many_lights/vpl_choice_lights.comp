#version 460
// What lights are chosen by, apart from the rest of them: every point reads all of it.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/many_lights/vpl_set_shared.h"
#include "renderer/many_lights/vpl_tree.glsl"

layout(local_size_x = VPL_SET_GROUP) in;
layout(set = 0, binding = 0, scalar) readonly buffer Counts { uint counts[VPL_COUNT_WORDS]; };
layout(set = 0, binding = 1, scalar) readonly buffer Vpls { Vpl vpls[]; };
layout(set = 0, binding = 2, std430) writeonly buffer ChoiceLights { vec4 choice_lights[]; };

void main() {
    const uint light = flat_index();
    if (light >= counts[VPL_COUNT]) return;
    const Vpl vpl = vpls[light];
    const float scatterings = float(vpl.scatterings);
    choice_lights[2u * light] = vec4(vpl.position, vpl_size(vpl));
    choice_lights[2u * light + 1u] = vec4(vpl.normal, vpl_is_lambert(vpl) ? scatterings : -scatterings);
}
