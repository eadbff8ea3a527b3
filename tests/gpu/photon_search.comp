#version 460
// What searches of a photon map find about places.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define GRID_STARTS_BINDING 0
#define GRID_PLACES_BINDING 1
#define MAP_POWERS_BINDING 2
#define NEAREST_GROUP TWIN_GROUP
#include "tests/gpu/twin.glsl"
#include "renderer/photons/radiance_estimate_shared.h"

layout(set = 0, binding = 3, scalar) readonly buffer Constants { EstimateConstants constants; };
#define ESTIMATE constants
#define COVERAGE constants.coverage
#define EDGE_WORD(index) 0u
#include "renderer/photons/radiance_estimate.glsl"

layout(set = 0, binding = 4, scalar) readonly buffer Queries { vec3 queries[]; };

struct PhotonsFound {
    float radius_m;
    uint photons;
    uint sum;  // of the words beside their places
};
layout(set = 0, binding = 5, scalar) writeonly buffer Out { PhotonsFound found_photons[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    const PhotonMapConstants map = constants.maps[0];
    PhotonDisc disc = PhotonDisc(map.radius_m, sqr(map.radius_m), 0u);
    if (map.nearest > 0) disc = find_nearest(map, queries[i]);
    PhotonsFound found = PhotonsFound(disc.radius_m, 0u, 0u);
    uint index;
    uvec4 point;
    float distance_sq;
    GridSearch search = grid_search(map.grid, queries[i], disc.radius_m);
    while (grid_next(map.grid, search, disc.bound_sq, index, point, distance_sq)) {
        if (distance_sq == disc.bound_sq) {
            if (disc.equals == 0) continue;
            --disc.equals;
        }
        ++found.photons;
        found.sum += point.w;
    }
    found_photons[i] = found;
}
