#version 460
// The wavefront's surfaces: what each path under way finds where it has arrived, its light sample, and whether it goes on.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/eye/path_wave.glsl"
#include "renderer/eye/path_step.glsl"

void main() {
    uint place;
    if (!queued_path(place)) return;
    const PathState state = path_states[place];
    EyePath path = unpack_path(state);
    Ray ray = ray_of(state);
    PathLight light = no_light();
    if (layer_kept(LAYER_ALBEDO)) light.albedo = load_rgb(LAYER_ALBEDO, path.pixel);
    PendingLight pending;
    const bool goes_on = shade_path(push.vertex, state.key, path_hits[place], path, ray, light, pending);
    store_light(path.pixel, light);
    if (goes_on) keep_path(place, path, ray, state.key);
    if (pending.wanted) add_shadow(pending, path.pixel);
}
