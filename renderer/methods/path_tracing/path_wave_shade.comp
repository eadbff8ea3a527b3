#version 460
// The wavefront's surfaces: what each path under way finds where it has arrived, its light sample, and whether it goes on.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/methods/path_tracing/path_wave.glsl"

void main() {
    uint place;
    if (!queued_path(place)) return;
    const PathState state = path_states[place];
    EyePath path = unpack_path(state);
    Ray ray = ray_of(state);
    PathLight light = no_light();
    if (layer_kept(PLANE_ALBEDO)) light.albedo = load_rgb(PLANE_ALBEDO, path.pixel);
    PendingLight pending;
    const bool goes_on = shade_path(push.vertex, state.key, path_hits[place], path, ray, light, pending);
    store_light(path.pixel, light);
    if (goes_on) {
        path_states[place] = pack_path(path, ray, state.key);
        path_queues[(1 - push.odd) * push.capacity + take_place(PATHS_NEXT)] = place;
    }
    if (pending.wanted) {
        ShadowState shadow;
        shadow.origin = pending.ray.origin, shadow.direction = pending.ray.direction, shadow.t_max = pending.ray.t_max;
        shadow.pixel = path.pixel, shadow.radiance = pending.radiance, shadow.indirect = pending.indirect ? 1 : 0;
        path_shadows[take_place(SHADOWS_NEXT)] = shadow;
    }
}
