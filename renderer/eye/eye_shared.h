// What paths from the eye share on the device (eye_scene.glsl), for both compilers. CPU twins: scene/camera.h,
// eye/pixel_filter.h, eye/eye_scene.h.
#ifndef PHOTOND_EYE_SHARED_H
#define PHOTOND_EYE_SHARED_H

#define EYE_TILE 8          // pixels along a side of the tile that a group of threads takes
#define FILTER_BINS 256     // PixelFilterSampler::kBins
#define FILTER_RADIUS 1.5f  // PixelFilterSampler::kRadius [pixels]

// Two-dimensional sets of random numbers: two for the camera, then four for each vertex, the camera's included. The
// first ones, which are distributed best (sobol.h), go where most of the variance comes from: the first bounce's
// direction and light, roulette, then the rest of the first vertices.
#define SET_FILM 4u
#define SET_LENS 14u
// Sets of random numbers for one vertex.
#define SET_LIGHT_POINT 0u
#define SET_LIGHT_CHOICE_AND_ROULETTE 1u
#define SET_DIRECTION 2u
#define SET_LOBE 3u
// The numbers that the first four vertices have for those four sets, vertex after vertex.
#define SETS_OF_FIRST_VERTICES 5, 2, 0, 8, 1, 7, 3, 12, 6, 11, 9, 15, 10, 16, 13, 17

#include "renderer/scene/camera_shared.h"

#ifdef __cplusplus
namespace photond::gpu {
using uint = uint32_t;
#endif

struct EyeConstants {
    CameraConstants camera;
    uint width;  // pixels
    uint height;
    uint smooth_filter;    // 0: box
    uint max_scatterings;  // EyeScene::max_scatterings
    uint roulette_start;   // surface interactions after which roulette may end a path
    float filter_cdf[FILTER_BINS + 1];
};

#ifdef __cplusplus
static_assert(sizeof(EyeConstants) == sizeof(CameraConstants) + 5 * 4 + 4 * (FILTER_BINS + 1),
              "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
