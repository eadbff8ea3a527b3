// A virtual point light, for both compilers. C++: many_lights/vpl.h, GLSL: vpl.glsl.
#ifndef PHOTOND_VPL_SHARED_H
#define PHOTOND_VPL_SHARED_H

#define NO_VPL_SURFACE 0xffffffffu  // Vpl::surface of a Lambert reflector

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

/// Light that leaves a surface from one point of it. [Keller 1997] Instant Radiosity. SIGGRAPH.
struct Vpl {
    vec3 position;       // world [m], on the surface
    float correction;    // of Lambert, by the shading normal: |cos_s| / |cos_g| of the light that arrived
    vec3 normal;         // geometric, unit, on the side that is lit
    uint smooth_normal;  // Octahedral<16>, on that side: `correction` counts for directions in front of it
    vec3 intensity;      // Lambert: along the normal, reflected flux / pi [W/sr]; others: flux that arrives [W]
    uint surface;        // others: index of what makes their BSDF again (ReflectingSurface); their rough part is meant
    uint scatterings;    // since the light, the one here included: at least 1
    float choice;        // choices among lights take it for that share of its size; 0: for all
};

#ifdef __cplusplus
static_assert(sizeof(Vpl) == 56, "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
