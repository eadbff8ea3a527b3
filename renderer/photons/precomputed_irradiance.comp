#version 460
// Irradiance at the marked photons of the global map; twin of PrecomputedIrradiance's constructor. A group takes a run of
// photons, gathers the marked ones and shares them out, so that its threads all have something to do.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define NEAREST_GROUP PRECOMPUTE_GROUP
#define GRID_STARTS_BINDING 0
#define GRID_PLACES_BINDING 1
#define MAP_POWERS_BINDING 2
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/photons/precomputed_irradiance_shared.h"

layout(local_size_x = PRECOMPUTE_GROUP) in;
layout(push_constant, scalar) uniform Push { PrecomputePush push; };
layout(set = 0, binding = 3, scalar) readonly buffer Constants { EstimateConstants estimate_constants; };
layout(set = 0, binding = 4, std430) writeonly buffer Irradiances { uvec4 irradiances[]; };  // the same as map_powers

#define ESTIMATE estimate_constants
#define COVERAGE estimate_constants.coverage
#define EDGE_WORD(index) grid_starts[index]
#include "renderer/photons/hash_grid.glsl"
#include "renderer/photons/radiance_estimate.glsl"

shared uint marked[PRECOMPUTE_PHOTONS];  // photons of the map
shared uint marked_count;

void work_out(uint photon) {
    const HashGridConstants grid = ESTIMATE.maps[PHOTON_MAP_GLOBAL].grid;
    const uvec4 place = grid_places[grid.first_point + photon];
    const vec3 position = uintBitsToFloat(place.xyz), normal = photon_normal(place.w);
    const uint direction = map_powers[grid.first_point + photon].w;
    const DiscQuery query = disc_query(hash32(direction), DISC_FINE_BATCH);
    const IrradianceEstimate found =
        estimate_irradiance(PHOTON_MAP_GLOBAL, position, normal, normal, push.most_scatterings, query);
    irradiances[ESTIMATE.first_irradiance + photon] = floatBitsToUint(vec4(found.irradiance, found.radius_m));
}

void main() {
    const HashGridConstants grid = ESTIMATE.maps[PHOTON_MAP_GLOBAL].grid;
    const uint photons = grid_starts[grid.first_start + grid.slots], lane = gl_LocalInvocationIndex;
    const uint first = flat_index() / PRECOMPUTE_GROUP * PRECOMPUTE_PHOTONS;
    if (lane == 0) marked_count = 0;
    barrier();
    for (uint i = first + lane; i < min(first + PRECOMPUTE_PHOTONS, photons); i += PRECOMPUTE_GROUP)
        if (photon_marked(grid_places[grid.first_point + i].w)) marked[atomicAdd(marked_count, 1u)] = i;
    barrier();
    for (uint i = lane; i < marked_count; i += PRECOMPUTE_GROUP) work_out(marked[i]);
}
