#version 460
// The wavefront's first kernel: a path for each pixel of a stretch of tiles.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/eye/path_wave.glsl"

/// push: `vertex` is the first tile, `odd` the one after the last.
void main() {
    const uint place = flat_index();
    const uint tile = push.vertex + place / (EYE_TILE * EYE_TILE);
    EyePath path;
    Ray ray;
    uint key;
    if (!start_eye_path(tile, push.odd, place % (EYE_TILE * EYE_TILE), path, ray, key)) return;
    path_states[place] = pack_path(path, ray, key);
    wave_queues[WAVE_COUNT_WORDS + take_place(WAVE_PATHS)] = place;
    count(COUNTER_CAMERA_RAYS, 1);
}
