#version 460
// The wavefront's first kernel: a path for each pixel of a stretch of tiles.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define IMAGE_BINDING 0
#define COUNTERS_BINDING 1
#define EYE_BINDING 2
#define SAMPLER_BINDING 3
#include "renderer/methods/path_tracing/path_wave.glsl"

/// push: `vertex` is the first tile, `odd` the one after the last.
void main() {
    const uint place = flat_index();
    const uint tile = push.vertex + place / (EYE_TILE * EYE_TILE);
    uint pixel;
    if (tile >= push.odd || !pixel_of_tile(tile, place % (EYE_TILE * EYE_TILE), pixel)) return;
    EyePath path;
    Ray ray;
    uint key;
    start_eye_path(pixel, path, ray, key);
    path_states[place] = pack_path(path, ray, key);
    path_queues[take_place(PATHS_NEXT)] = place;
    count(COUNTER_CAMERA_RAYS, 1);
}
