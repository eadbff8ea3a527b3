#version 460
// The wavefront's last kernel: the few paths that are left are followed to their ends by a thread each.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define PATH_WAVE_TAIL
#include "renderer/eye/path_wave.glsl"
#include "renderer/eye/path_step.glsl"

void main() {
    uint place;
    if (!queued_path(place)) return;
    const PathState state = path_states[place];
    PathLight light = no_light();
    if (layer_kept(LAYER_ALBEDO)) light.albedo = load_rgb(LAYER_ALBEDO, state.pixel);
    uint vertex = push.vertex, shadow_rays = 0;
    follow_path(state.key, vertex, unpack_path(state), ray_of(state), light, shadow_rays);
    store_light(state.pixel, light);
    count(COUNTER_BOUNCE_RAYS, vertex - push.vertex);
    count(COUNTER_SHADOW_RAYS, shadow_rays);
}
