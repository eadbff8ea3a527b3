// A path from the eye as it waits between the kernels of a wavefront, for both compilers.
#ifndef PHOTOND_PATH_WAVEFRONT_SHARED_H
#define PHOTOND_PATH_WAVEFRONT_SHARED_H

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

struct PathWavePush {
    uint vertex;    // of all paths under way
    uint odd;       // which of the two queues they are in
    uint capacity;  // paths there is room for
};

/// A path between two of its vertices: EyePath, its ray and its key.
struct PathState {
    vec3 throughput;
    float pdf_sa;
    vec3 position;
    float eta_scale;
    vec3 lit_normal;
    uint pixel;
    vec3 origin;
    uint key;
    vec3 direction;
    uint flags;  // scatterings, PATH_DELTA, PATH_CAUSTIC
    uint media[4];
};
#define PATH_DELTA 0x80000000u
#define PATH_CAUSTIC 0x40000000u

/// A light sample that waits for its shadow ray.
struct ShadowState {
    vec3 origin;
    float t_max;
    vec3 direction;
    uint pixel;
    vec3 radiance;
    uint indirect;  // 0 or 1
};

#ifdef __cplusplus
static_assert(sizeof(PathState) == 96 && sizeof(ShadowState) == 48, "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
