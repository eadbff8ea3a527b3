// Depth maps of a scene's punctual lights, for both compilers. light_depth_maps.h says what they are.
#ifndef PHOTOND_LIGHT_DEPTH_SHARED_H
#define PHOTOND_LIGHT_DEPTH_SHARED_H

#define LIGHT_DEPTH_GROUP 64

// LightDepthMap::kind
#define LIGHT_DEPTH_CUBE 0u      // six faces about a point
#define LIGHT_DEPTH_CONE 1u      // one perspective map about an axis
#define LIGHT_DEPTH_PARALLEL 2u  // orthographic

// Depth over distance across (light_depth_maps.h).
#define LIGHT_DEPTH_MOST_SLOPE 6.0f  // 80.5 degrees of incidence
#define LIGHT_DEPTH_CONCAVE_SLOPE 2.0f

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

/// The map of one punctual light. A texel's ray starts at `origin` (PARALLEL: on the plane through it) and its depth is
/// the distance along that ray [m], infinite where nothing is met.
struct LightDepthMap {
    vec3 origin;
    uint kind;
    vec3 axis;        // unit; PARALLEL, CONE. Texels go along the tangent and bitangent of its frame
    float half_side;  // of the map: [m] where PARALLEL, else at distance 1 along the axis
    uint first_texel;
};

struct LightDepthConstants {
    uint resolution;    // texels along a side
    float pcf;          // side of the square that is asked at random [texels]
    uint first_source;  // of the first map's light: LightSample::source
    uint maps;
};

struct LightDepthPush {
    uint first_texel;  // of all maps
    uint end_texel;
};

#ifdef __cplusplus
static_assert(sizeof(LightDepthMap) == 36 && sizeof(LightDepthConstants) == 16 && sizeof(LightDepthPush) == 8,
              "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
