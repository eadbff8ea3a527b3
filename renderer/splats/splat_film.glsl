// Where splats are drawn on the film.
#ifndef PHOTOND_SPLAT_FILM_GLSL
#define PHOTOND_SPLAT_FILM_GLSL

#include "renderer/core/geometry.glsl"
#include "renderer/scene/camera_shared.h"

/// How far from the middle of a pixel its samples lie, at most [pixels]. `reach`: of the pixel filter along an axis.
float sample_reach(float reach) { return 1.42 * reach; }

/// So many pixels at that depth [m].
float pixels_m(CameraConstants camera, float pixels, float depth_m) {
    return pixels * (camera.orthographic != 0 ? 1.0 : max(depth_m, 0.0)) *
           max(length(camera.pixel_x), length(camera.pixel_y));
}

/// Of a film of that size; `d`: from the eye. In the middle of the depths that are drawn.
vec4 film_position(CameraConstants camera, vec2 size, vec3 d) {
    const float w = camera.orthographic != 0 ? 1.0 : dot(d, camera.forward);
    const vec3 on_film = d - w * camera.corner;
    const vec2 film = vec2(dot(on_film, camera.pixel_x) / dot(camera.pixel_x, camera.pixel_x),
                           dot(on_film, camera.pixel_y) / dot(camera.pixel_y, camera.pixel_y));  // pixels, times w
    return vec4(2.0 * film / size - w, 0.5 * w, w);
}

/// Nothing is drawn there.
const vec4 OFF_FILM = vec4(0.0, 0.0, -1.0, 0.0);

#endif
