// Whose the texels of a map are, for both compilers. C++: texel_map.h, GLSL: texel_map.glsl.
#ifndef PHOTOND_TEXEL_MAP_SHARED_H
#define PHOTOND_TEXEL_MAP_SHARED_H

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

/// A light's texels.
struct TexelRun {
    uint light;
    uint first_texel;
    uint texels;
    float expected;  // texels that the light's flux is divided by
};

#ifdef __cplusplus
static_assert(sizeof(TexelRun) == 16, "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
