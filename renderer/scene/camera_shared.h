// The camera's rays on the device (camera.glsl), for both compilers.
#ifndef PHOTOND_CAMERA_SHARED_H
#define PHOTOND_CAMERA_SHARED_H

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

/// CameraRays (camera.h) of one film size.
struct CameraConstants {
    vec3 corner;  // top left corner of the image on the plane at unit distance, less the eye
    float aperture_radius_m;
    vec3 pixel_x;  // steps of one pixel on that plane
    float focus_distance_m;
    vec3 pixel_y;
    uint orthographic;  // 0 or 1
    vec3 position;
    vec3 forward;
    vec3 right;
    vec3 up;
};

#ifdef __cplusplus
static_assert(sizeof(CameraConstants) == 96, "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
