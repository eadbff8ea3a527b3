#version 460
// The wavefront's surfaces: what each path from the eye finds where it has arrived, its light sample, whether it goes on,
// and whether its vertex is to be joined with light paths.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define LIGHT_TABLES_BINDING 10
#include "renderer/bidirectional/joined_wave.glsl"

layout(set = 0, binding = 11, scalar) writeonly buffer Joins { JoinState joins[]; };

void main() {
    uint place;
    if (!queued_path(place)) return;
    const PathState state = path_states[place];
    const uint key = state.key;
    EyePath path = unpack_path(state);
    Ray ray = ray_of(state);
    SubpathWeights weights;
    if (push.vertex == 0)
        weights = start_weights(ray);
    else
        weights = path_weights[place];
    const Ray arrived = ray;
    PathLight light = no_light();
    if (layer_kept(LAYER_ALBEDO)) light.albedo = load_rgb(LAYER_ALBEDO, path.pixel);
    PendingLight pending;
    JoinVertex at;
    bool joins_others;
    const bool goes_on =
        shade_joined(push.vertex, key, path_hits[place], path, weights, ray, light, pending, at, joins_others);
    store_light(path.pixel, light);
    if (goes_on) {
        path_weights[place] = weights;
        keep_path(place, path, ray, key);
    }
    if (pending.wanted) add_shadow(pending, path.pixel);
    if (!joins_others) return;
    JoinState join;
    join.path = pack_path(at.path, arrived, key);
    join.weights = at.weights;
    const ShadingPoint point = at.surface.point;
    join.instance = point.instance, join.triangle = point.triangle, join.u = point.u, join.v = point.v;
    join.outside_ior = at.outside_ior, join.acceptance = at.acceptance;
    joins[take_place(WAVE_JOINS)] = join;
}
