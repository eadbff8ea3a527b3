#version 460
// New cells of a round, by a cascade whose outcome does not depend on the order. CPU twin: RadianceCells::insert().
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/methods/radiance_cache/cache_rounds.glsl"

void insert(CellKey key) {
    const uint first = first_slot(key), older = first + older_cells[first / CACHE_SLOTS];
    for (uint slot = first; slot < older; ++slot)
        if (fingerprints[slot] == key.fingerprint) return;
    uint carried = key.fingerprint;
    for (uint slot = older; slot < first + CACHE_SLOTS && carried != 0u; ++slot) {
        const uint there = atomicMax(fingerprints[slot], carried);
        if (there == carried) return;
        carried = min(carried, there);
    }
}

void main() {
    uint record;
    if (!record_of_thread(flat_index(), record)) return;
    const uint coarser = coarser_levels_of(record);
    for (uint i = 0u; i <= coarser; ++i) insert(key_of(record, i));
}
