// GLSL twin of scene/camera_projection.h.
#ifndef PHOTOND_CAMERA_PROJECTION_GLSL
#define PHOTOND_CAMERA_PROJECTION_GLSL

#include "renderer/scene/camera_shared.h"

/// False: behind the eye.
bool project(CameraConstants camera, vec3 position, out vec2 film) {
    vec3 plane = position - camera.position;
    const float depth = dot(plane, camera.forward);
    film = vec2(0.0);
    if (camera.orthographic == 0) {
        if (!(depth > 0.0)) return false;
        plane /= depth;
    }
    const vec3 across = plane - camera.corner;
    film = vec2(dot(across, camera.pixel_x) / dot(camera.pixel_x, camera.pixel_x),
                dot(across, camera.pixel_y) / dot(camera.pixel_y, camera.pixel_y));
    return true;
}

#endif
