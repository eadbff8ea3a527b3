// Two neighbouring levels of the maps' pyramids: what imperfect_pull.comp and imperfect_push.comp have in common.
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/core/geometry.glsl"
#include "renderer/many_lights/imperfect_shadow_maps_shared.h"

layout(local_size_x = IMPERFECT_GROUP) in;
layout(push_constant, scalar) uniform Push { ImperfectLevelPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Counts { uint counts[]; };

/// Distances that differ by more, as a share, are of different surfaces.
const float SAME_SURFACE = 0.2;

/// Whether this thread's light is one. `side`: of the level that has a thread a texel.
bool level_texel(uint side, out uint light, out uvec2 at) {
    light = flat_index() / (side * side);
    at = uvec2(flat_index() % side, flat_index() / side % side);
    return light < min(counts[push.count_word], push.most_lights);
}
