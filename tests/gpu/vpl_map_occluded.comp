#version 460
// Whether virtual lights see points, by their depth maps.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define VPL_MAPS_BINDING 0
#include "renderer/many_lights/vpl_shadow_maps.glsl"
#include "renderer/many_lights/vpl_shared.h"
#include "tests/gpu/twin.glsl"

struct Question {
    uint light;
    uint resolution;
    vec3 point;
};
layout(set = 0, binding = 1, scalar) readonly buffer Vpls { Vpl vpls[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Questions { Question questions[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer Answers { uint occluded[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    const Question question = questions[i];
    const Vpl vpl = vpls[question.light];
    occluded[i] = vpl_map_occluded(question.light, vpl.position, make_frame(vpl.normal), question.point,
                                   question.resolution) ? 1u : 0u;
}
