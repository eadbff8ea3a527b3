#version 460
// Tells where new cells of a round may go, and makes place for one where there is none: cells move up in their order. A
// thread a bucket. What a unit of the sums is follows from the first round that was not black. CPU twin:
// RadianceCells::make_room().
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/methods/radiance_cache/cache_rounds.glsl"

void move_cell(uint from, uint to) {
    for (uint word = 0u; word < CACHE_SUM_WORDS; ++word)
        cell_sums[CACHE_SUM_WORDS * to + word] = cell_sums[CACHE_SUM_WORDS * from + word];
    fingerprints[to] = fingerprints[from];
}

void main() {
    const uint bucket = flat_index();
    if (bucket >= cache.buckets) return;
    if (bucket == 0u && cache_state[CACHE_BRIGHTEST] == 0u) cache_state[CACHE_BRIGHTEST] = cache_state[CACHE_FOUND];
    const uint first = CACHE_SLOTS * bucket;
    uint cells = 0u;
    while (cells < CACHE_SLOTS && fingerprints[first + cells] != 0u) ++cells;
    if (cells == CACHE_SLOTS) {
        cells = 0u;
        for (uint slot = first; slot < first + CACHE_SLOTS; ++slot) {
            if (cell_sums[CACHE_SUM_WORDS * slot + CACHE_ROUND_WORD] + CACHE_MOST_AGE < push.round) continue;
            if (first + cells < slot) move_cell(slot, first + cells);
            ++cells;
        }
        for (uint slot = first + cells; slot < first + CACHE_SLOTS; ++slot) {
            for (uint word = 0u; word < CACHE_SUM_WORDS; ++word) cell_sums[CACHE_SUM_WORDS * slot + word] = 0u;
            fingerprints[slot] = 0u;
        }
    }
    older_cells[bucket] = cells;
}
