#version 460
// Chains take the steps proposed or stay, and leave their states when they go, a thread a chain. CPU twin:
// walk_chains() in path_selection.cpp.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/many_lights/path_selection.glsl"

layout(set = 0, binding = 0, scalar) buffer Chains { PathChain chains[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Proposed { VplPath proposed[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Targets { float targets[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer Selected { VplPath selected[]; };
layout(set = 0, binding = 4, scalar) buffer PathCounts { uint path_counts[PATH_COUNT_WORDS]; };

/// The last step: there is nothing proposed.
bool is_end() { return push.step == push.states; }

void main() {
    const uint index = flat_index();
    if (index >= push.chains) return;
    PathChain chain = chains[index];
    if (!is_end() && !(chain.chance * chain.target < targets[index])) {
        chains[index].times = chain.times + 1u;
        return;
    }
    const float share = float(push.vpls) / float(push.chains * push.states);
    selected[index * push.states + chain.left] =
        VplPath(chain.point_x, chain.point_y, chain.element,
                share * chain.mean_target * float(chain.times) / chain.target, chain.choice);
    if (is_end()) return;
    const VplPath path = proposed[index];
    chains[index] = PathChain(path.point_x, path.point_y, path.element, targets[index], chain.mean_target, 1u,
                              chain.left + 1u, 0.0, path.choice);
    atomicAdd(path_counts[PATHS_ACCEPTED], 1u);
}
