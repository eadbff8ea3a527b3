#version 460
// Which candidates are kept, a thread a candidate: their weights, and 1 or 0. CPU twin: accept() in path_selection.cpp.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/many_lights/path_selection.glsl"

layout(set = 0, binding = 0, scalar) readonly buffer Targets { float targets[]; };
layout(set = 0, binding = 1, scalar) buffer Candidates { VplPath candidates[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Kept { uint kept[]; };

void main() {
    const uint i = flat_index();
    if (i >= push.candidates) return;
    const float chance = min(targets[i], 1.0);
    RandomStream random = numbers_of(PATH_STAGE_ACCEPTANCE, i);
    kept[i] = random_stream_next(random) < chance ? 1u : 0u;
    candidates[i].weight = float(push.vpls) / float(push.candidates) / chance;
}
