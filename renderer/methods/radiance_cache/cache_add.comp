#version 460
// The samples of a round added to their cells, in whole units by chance. CPU twin: RadianceCells::add().
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/methods/radiance_cache/cache_rounds.glsl"

void add_units(uint word, float units, uint random) {
    const float most = min(units, CACHE_MOST_UNITS), whole = floor(most);
    const float upper = floor(whole / 4294967296.0);
    uint low = uint(whole - upper * 4294967296.0), high = uint(upper);
    if (to_unit_float(random) < most - whole && ++low == 0u) ++high;
    const uint before = atomicAdd(cell_sums[word], low);
    if (before + low < before) ++high;
    if (high != 0u) atomicAdd(cell_sums[word + 1u], high);
}

bool add(CellKey key, vec3 radiance, uint random) {
    const uint slot = slot_of(key);
    if (slot == NO_SLOT) return false;
    const uint first = CACHE_SUM_WORDS * slot;
    cell_sums[first + CACHE_ROUND_WORD] = push.round;
    atomicAdd(cell_sums[first + CACHE_SAMPLES_WORD], 1u);
    const float unit = cache_unit();
    if (!(unit > 0.0)) return true;  // all samples are black
    for (uint c = 0u; c < 3u; ++c) {
        random = hash32(random + c);
        add_units(first + 2u * c, radiance[c] / unit, random);
    }
    return true;
}

void main() {
    uint record, refused = 0u;
    if (record_of_thread(flat_index(), record)) {
        const uint coarser = coarser_levels_of(record), level = records[record].level_and_direction & 31u;
        for (uint i = 0u; i <= coarser; ++i)
            if (!add(key_of(record, i), records[record].own_rough, records[record].random + level - i)) ++refused;
    }
    count_in_cache(CACHE_REFUSED, refused);
}
