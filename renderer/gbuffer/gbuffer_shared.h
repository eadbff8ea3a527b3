// The G-buffer: one visible point a pixel, for both compilers.
#ifndef PHOTOND_GBUFFER_SHARED_H
#define PHOTOND_GBUFFER_SHARED_H

// The bits of GBufferPoint::kind.
#define GBUFFER_POINT 0x40000000u    // there is a point; else the pixel waits for nothing
#define GBUFFER_GENERAL 0x80000000u  // it is not Lambert: GBufferGeneral at the same index tells more
#define GBUFFER_SCATTERINGS 0xffu    // scatterings that light may have had before it reaches the point

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
using glm::uvec4;
#endif

/// Where a path from the eye waits for indirect light. A path that left several such points (behind a coat, in a
/// tinted mirror) keeps one, by chance in proportion to what it may show; `weight` makes up for the others.
struct GBufferPoint {
    vec3 position;  // world [m]
    uint kind;
    vec3 normal;            // that shades, unit; 0 where light from both sides counts
    float depth_m;          // along the camera's forward axis
    vec3 geometric_normal;  // unit, on the eye's side
    uint pixel;
    vec3 weight;  // Lambert: throughput times reflectance / pi, of irradiance; others: throughput, of radiance
    float total;  // what the choice between the pixel's points has gone by so far
};

/// What makes the BSDF of a point that is not Lambert again: make_shading_point(), make_bsdf(), its rough part.
struct GBufferGeneral {
    float t;  // the hit
    uint instance;
    uint triangle;
    float u;
    float v;
    vec3 ray_direction;
    float outside_ior;
    uvec4 media;  // MediumStack
};

#ifdef __cplusplus
static_assert(sizeof(GBufferPoint) == 64 && sizeof(GBufferGeneral) == 52, "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
