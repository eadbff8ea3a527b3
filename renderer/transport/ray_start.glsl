// GLSL twin of transport/ray_start.h: where rays start.
#ifndef PHOTOND_RAY_START_GLSL
#define PHOTOND_RAY_START_GLSL

#include "renderer/core/geometry.glsl"

const float CLEARANCE = 8.0 / 16777216.0;  // kClearance
const float STEP_OFF = 1.0 / 65536.0;      // kStepOff

/// How far [m] from its plane a point of the triangle may come to lie, and a ray from there may find that plane.
float surface_clearance(vec3 a, vec3 b, vec3 c) { return CLEARANCE * max_component(max(max(abs(a), abs(b)), abs(c))); }

/// offset_ray_origin() without its least distance in metres: for points that have their triangle's clearance.
vec3 step_off(vec3 p, vec3 n) { return p + STEP_OFF * n * abs(p); }

/// surface_clearance() of all points corner + s edge1 + t edge2, s and t from 0 to 1.
float patch_clearance(vec3 corner, vec3 edge1, vec3 edge2) {
    return CLEARANCE * max_component(abs(corner) + abs(edge1) + abs(edge2));
}

/// Where rays from a point of a surface start that has that clearance, towards the side of the unit normal `n`.
vec3 clear_of_surface(vec3 p, vec3 n, float clearance_m) { return step_off(p + clearance_m * n, n); }

#endif
