// How wide a lamp looks: lamps.h.
#ifndef PHOTOND_LAMPS_GLSL
#define PHOTOND_LAMPS_GLSL

#include "renderer/gbuffer/lamps_shared.h"

/// Radius [m] of the disc that spreads as widely across the direction `w` (unit): a disc of radius r has variance r^2 / 4
/// along either axis.
float lamp_radius_m(LampShape shape, vec3 w) {
    const float along = dot(shape.variance_m2, w * w) + 2.0 * dot(shape.covariance_m2, w.yzx * w.zxy);
    return sqrt(max(2.0 * (shape.variance_m2.x + shape.variance_m2.y + shape.variance_m2.z - along), 0.0));
}

#endif
