// What paths from the eye share on the device (eye_scene.glsl), for both compilers. CPU twins: scene/camera.h,
// methods/pixel_filter.h, methods/eye_scene.h.
#ifndef PHOTOND_EYE_SHARED_H
#define PHOTOND_EYE_SHARED_H

#define EYE_TILE 8          // pixels along a side of the tile that a group of threads takes
#define FILTER_BINS 256     // PixelFilterSampler::kBins
#define FILTER_RADIUS 1.5f  // PixelFilterSampler::kRadius [pixels]

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

struct EyeConstants {
    vec3 corner;   // CameraRays: top left corner of the image on the plane at unit distance, less the eye
    uint width;    // pixels
    vec3 pixel_x;  // steps of one pixel on that plane
    uint height;
    vec3 pixel_y;
    uint orthographic;  // 0 or 1
    vec3 position;      // of the camera
    float aperture_radius_m;
    vec3 forward;
    float focus_distance_m;
    vec3 right;
    uint smooth_filter;  // 0: box
    vec3 up;
    uint max_scatterings;  // EyeScene::max_scatterings
    uint roulette_start;   // surface interactions after which roulette may end a path
    float filter_cdf[FILTER_BINS + 1];
};

#ifdef __cplusplus
static_assert(sizeof(EyeConstants) == 7 * 16 + 4 + 4 * (FILTER_BINS + 1), "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
