// GLSL twin of eye/eye_scene.h and eye_path.h: how paths from the eye start, and what they carry. Define EYE_BINDING
// (of set 0) before, and SAMPLER_BINDING where paths start.
#ifndef PHOTOND_EYE_SCENE_GLSL
#define PHOTOND_EYE_SCENE_GLSL

#include "renderer/eye/eye_shared.h"
#include "renderer/scene/camera.glsl"
#include "renderer/transport/sobol.glsl"
#include "renderer/transport/medium_stack.glsl"

layout(set = 0, binding = EYE_BINDING, scalar) readonly buffer Eye { EyeConstants eye; };

/// One path from the eye between two of its vertices; members as EyePath's.
struct EyePath {
    vec3 throughput;
    float pdf_sa;
    vec3 position;
    float eta_scale;
    vec3 lit_normal;
    uint pixel;
    uint scatterings;
    bool delta;
    bool caustic;
    MediumStack media;
};

// Two-dimensional sets of random numbers, as sample_set() of eye_scene.h numbers them.
const uint kFirstVertices[16] = uint[](SETS_OF_FIRST_VERTICES);
uint sample_set(uint vertex, uint kind) { return vertex < 4 ? kFirstVertices[4 * vertex + kind] : 2 + 4 * vertex + kind; }

/// PixelFilterSampler: the inverse of the smooth filter's distribution.
float invert_filter(float u) {
    uint low = 0, high = FILTER_BINS;  // the last edge at or below u lies in [low, high)
    while (high - low > 1) {
        const uint middle = (low + high) / 2;
        if (eye.filter_cdf[middle] <= u) low = middle; else high = middle;
    }
    const float below = eye.filter_cdf[low], above = eye.filter_cdf[low + 1];
    const float within = above > below ? (u - below) / (above - below) : 0.5;
    return -FILTER_RADIUS + (float(low) + within) * (2.0 * FILTER_RADIUS / float(FILTER_BINS));
}

/// Threads take the image in tiles of EYE_TILE x EYE_TILE pixels, so that those that run together look the same way. False
/// past the image's edge.
bool pixel_of_tile(uint tile, uint place, out uint pixel) {
    const uint columns = (eye.width + EYE_TILE - 1) / EYE_TILE;
    const uint x = tile % columns * EYE_TILE + place % EYE_TILE, y = tile / columns * EYE_TILE + place / EYE_TILE;
    pixel = y * eye.width + x;
    return x < eye.width && y < eye.height;
}

/// Scatterings left to a photon that is looked up after so many of the eye's path, the lookup's own included.
uint photon_scatterings_left(uint scatterings) {
    const uint most = eye.max_scatterings;
    return most == 0xffffffffu ? most : most - min(most, scatterings);
}

#ifdef SAMPLER_BINDING

/// The path of a pixel, its camera ray and its key of the sampler. Twin: start_eye_paths() of tiles.cpp.
void start_eye_path(uint pixel, out EyePath path, out Ray ray, out uint key) {
    key = pixel_key(pixel);
    path = EyePath(vec3(1.0), 0.0, vec3(0.0), 1.0, vec3(0.0), pixel, 0, true, true, make_medium_stack());
    const vec2 u = sample_2d(key, SET_FILM);
    const vec2 within = eye.smooth_filter != 0 ? vec2(0.5) + vec2(invert_filter(u.x), invert_filter(u.y)) : u;
    const vec2 lens = eye.camera.aperture_radius_m > 0.0 ? sample_2d(key, SET_LENS) : vec2(0.0);
    ray = camera_ray(eye.camera, vec2(pixel % eye.width, pixel / eye.width) + within, lens);
}
/// The same of a place in a tile. False where there is none: past the image's edge, or from `end_tile` on.
bool start_eye_path(uint tile, uint end_tile, uint place, out EyePath path, out Ray ray, out uint key) {
    uint pixel;
    if (tile >= end_tile || !pixel_of_tile(tile, place, pixel)) return false;
    start_eye_path(pixel, path, ray, key);
    return true;
}

#endif

#endif
