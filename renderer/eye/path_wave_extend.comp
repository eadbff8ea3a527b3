#version 460
// The wavefront's rays: where each path under way meets a surface next.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/eye/path_wave.glsl"

void main() {
    uint place;
    if (!queued_path(place)) return;
    path_hits[place] = closest_hit(Ray(path_states[place].origin, path_states[place].direction, INFINITY));
    if (push.vertex > 0) count(COUNTER_BOUNCE_RAYS, 1);
}
