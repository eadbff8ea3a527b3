// Which pixel shows a place of the scene. Define SHOWN_POINTS (an array of GBufferPoint) before.
#ifndef PHOTOND_SHOWN_PLACES_GLSL
#define PHOTOND_SHOWN_PLACES_GLSL

#include "renderer/eye/eye_shared.h"
#include "renderer/gbuffer/gbuffer_shared.h"
#include "renderer/gbuffer/split_buffer.glsl"
#include "renderer/scene/camera_projection.glsl"

/// `depth_share`: how far apart the depths of the place and of the pixel's point may be, over the latter. False: no pixel
/// shows it.
bool pixel_that_shows(EyeConstants eye, SplitRecord split, vec3 position, float depth_share, out uint pixel) {
    pixel = 0;
    vec2 film;
    if (!project(eye.camera, position, film) || !(film.x >= 0.0 && film.y >= 0.0)) return false;
    if (!(film.x < float(eye.width) && film.y < float(eye.height))) return false;
    const uint x = uint(film.x), y = uint(film.y), point = split_point_of(split, x, y);
    const float depth_m = dot(position - eye.camera.position, eye.camera.forward);
    pixel = y * eye.width + x;
    return SHOWN_POINTS[point].kind != 0u &&
           abs(depth_m - SHOWN_POINTS[point].depth_m) <= depth_share * SHOWN_POINTS[point].depth_m;
}

#endif
