// For both compilers.
#ifndef PHOTOND_PATH_TRACING_SHARED_H
#define PHOTOND_PATH_TRACING_SHARED_H

#define PATH_QUEUE_GROUP 64

// The wavefront's words of its counts: paths under way, those that go on, shadow rays that wait, those being traced;
// and the groups of the dispatches over paths and over shadow rays, three words each.
#define PATHS_NOW 0
#define PATHS_NEXT 1
#define SHADOWS_NEXT 2
#define SHADOWS_NOW 3
#define PATH_GROUPS 4
#define SHADOW_GROUPS 8
#define PATH_COUNT_WORDS 12

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

/// A stretch of the film's tiles (pixel_of_tile() in eye_scene.glsl), a group each.
struct PathTracingPush {
    uint first_tile;
    uint end_tile;
};

struct PathWavePush {
    uint vertex;    // of all paths under way
    uint odd;       // which of the two queues they are in
    uint capacity;  // paths there is room for
};

/// A path of the wavefront between two of its vertices: EyePath, its ray and its key.
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
