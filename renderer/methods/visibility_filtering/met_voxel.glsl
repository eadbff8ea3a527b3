// What a ray of a list meets, and what of it the next frame is told.
#ifndef PHOTOND_MET_VOXEL_GLSL
#define PHOTOND_MET_VOXEL_GLSL

#include "renderer/core/geometry.glsl"

struct MetVoxel {
    uint slot;
    bool where_lit;  // on a side that light reaches, for lists that count
    vec3 place;      // of what is met there: the middle of a disc
};

// Where a ray meets nothing it is known by a place so far off that nothing is there.
#define NO_PLACE vec3(INFINITY)  // there is no ray
const float FAR = 1e30;
vec3 far_place(vec3 direction) { return FAR * direction; }
bool is_far(vec3 place) { return any(greaterThan(abs(place), vec3(0.1 * FAR))); }
vec3 direction_to(vec3 place, vec3 from) { return normalize(is_far(place) ? place / FAR : place - from); }

#endif
