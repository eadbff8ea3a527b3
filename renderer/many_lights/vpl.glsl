// GLSL twin of many_lights/vpl.h.
#ifndef PHOTOND_VPL_GLSL
#define PHOTOND_VPL_GLSL

#include "renderer/many_lights/vpl_shared.h"

bool vpl_is_lambert(Vpl vpl) { return vpl.surface == NO_VPL_SURFACE; }

/// 1 / max(B, d^2); 0 at no distance at all.
float clamped_falloff(float distance_sq, float clamp_sq) {
    const float divisor = max(distance_sq, clamp_sq);
    return divisor > 0.0 ? 1.0 / divisor : 0.0;
}

/// Where the shadow ray of a connection ends, over its length (vpl.h).
const float kConnectionEnd = 1.0 - 1.0 / 262144.0;

#endif
