// The samples of a round on their way to their cells, a thread a record of a path.
#ifndef PHOTOND_CACHE_ROUNDS_GLSL
#define PHOTOND_CACHE_ROUNDS_GLSL

#define CACHE_CONSTANTS_BINDING 0
#define CACHE_STATE_BINDING 1
#define CACHE_FINGERPRINTS_BINDING 2
#define CACHE_SUMS_BINDING 3
#define CACHE_ACCESS
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/methods/radiance_cache/radiance_cells.glsl"
#include "renderer/photons/photon.glsl"

layout(local_size_x = CACHE_GROUP) in;
layout(push_constant, scalar) uniform Push { CacheRoundPush push; };
layout(set = 0, binding = 4, scalar) buffer OlderCells { uint older_cells[]; };  // by bucket, in its first slots
layout(set = 0, binding = 5, scalar) readonly buffer Records { CacheRecord records[]; };
layout(set = 0, binding = 6, scalar) readonly buffer RecordCounts { uint record_counts[]; };  // by path

/// Which record a thread has. False: none.
bool record_of_thread(uint thread, out uint record) {
    record = thread;
    return thread < CACHE_MOST_RECORDS * push.paths && thread % CACHE_MOST_RECORDS < record_counts[thread / CACHE_MOST_RECORDS];
}

/// The cell that a record's sample belongs to, so many levels coarser than its own.
CellKey key_of(uint record, uint coarser) {
    const uint at = records[record].level_and_direction;
    return cell_key(records[record].position, octahedral_decode(16u, records[record].normal), at >> 5, (at & 31u) - coarser);
}
uint coarser_levels_of(uint record) {
    return coarser_levels(records[record].level_and_direction & 31u, records[record].spread_m);
}

#endif
