// GLSL twin of scene/camera.h: CameraRays.
#ifndef PHOTOND_CAMERA_GLSL
#define PHOTOND_CAMERA_GLSL

#include "renderer/core/geometry.glsl"
#include "renderer/scene/camera_shared.h"

/// Maps the unit square to the unit disc with little distortion.
/// [Shirley and Chiu 1997] A Low Distortion Map Between Disk and Square. JGT 2(3).
vec2 concentric_disc(vec2 u) {
    const vec2 offset = 2.0 * u - vec2(1.0);
    if (offset.x == 0.0 && offset.y == 0.0) return vec2(0.0);
    float radius, phi;
    if (abs(offset.x) > abs(offset.y)) {
        radius = offset.x;
        phi = PI / 4.0 * (offset.y / offset.x);
    } else {
        radius = offset.y;
        phi = PI / 2.0 - PI / 4.0 * (offset.x / offset.y);
    }
    return radius * vec2(cos(phi), sin(phi));
}

/// Starts the ray through image position `film` (pixels; (0,0) is the top left corner) from lens position `lens`.
Ray camera_ray(CameraConstants camera, vec2 film, vec2 lens) {
    const vec3 plane = camera.corner + film.x * camera.pixel_x + film.y * camera.pixel_y;
    vec3 origin = camera.position;
    vec3 direction = plane;
    if (camera.orthographic != 0) origin += plane, direction = camera.forward;
    if (camera.aperture_radius_m > 0.0) {
        const vec2 disc = camera.aperture_radius_m * concentric_disc(lens);
        const vec3 shift = disc.x * camera.right + disc.y * camera.up;
        direction -= shift / camera.focus_distance_m;
        origin += shift;
    }
    return Ray(origin, normalize(direction), INFINITY);
}

#endif
