// GLSL twin of radiance_cells.h: what cells know. Define CACHE_CONSTANTS_BINDING, CACHE_STATE_BINDING,
// CACHE_FINGERPRINTS_BINDING and CACHE_SUMS_BINDING (of set 0) before, and CACHE_ACCESS where they are not only read.
#ifndef PHOTOND_RADIANCE_CELLS_GLSL
#define PHOTOND_RADIANCE_CELLS_GLSL

#extension GL_KHR_shader_subgroup_arithmetic : require

#include "renderer/methods/radiance_cache/cell_grid.glsl"

#ifndef CACHE_ACCESS
#define CACHE_ACCESS readonly
#endif

layout(set = 0, binding = CACHE_STATE_BINDING, scalar) buffer CacheState { uint cache_state[CACHE_STATE_WORDS]; };
layout(set = 0, binding = CACHE_FINGERPRINTS_BINDING, scalar) CACHE_ACCESS buffer CacheFingerprints { uint fingerprints[]; };
layout(set = 0, binding = CACHE_SUMS_BINDING, scalar) CACHE_ACCESS buffer CacheSums { uint cell_sums[]; };

const uint NO_SLOT = 0xffffffffu;

uint first_slot(CellKey key) { return CACHE_SLOTS * (key.place & (cache.buckets - 1u)); }

uint slot_of(CellKey key) {
    const uint first = first_slot(key);
    for (uint slot = first; slot < first + CACHE_SLOTS; ++slot)
        if (fingerprints[slot] == key.fingerprint) return slot;
    return NO_SLOT;
}

/// Of the sums: a share of the brightest channel that the first samples had.
float cache_unit() { return uintBitsToFloat(cache_state[CACHE_BRIGHTEST]) / CACHE_UNITS_OF_MOST; }

/// Mean of all samples of a cell so far, and their number; 0: there is no such cell.
uint cell_mean(CellKey key, out vec3 radiance) {
    radiance = vec3(0.0);
    const uint slot = slot_of(key);
    if (slot == NO_SLOT) return 0u;
    const uint samples = cell_sums[CACHE_SUM_WORDS * slot + CACHE_SAMPLES_WORD];
    if (samples == 0u) return 0u;
    for (int c = 0; c < 3; ++c) {
        const uint word = CACHE_SUM_WORDS * slot + 2u * uint(c);
        radiance[c] = (float(cell_sums[word + 1u]) * 4294967296.0 + float(cell_sums[word])) / float(samples) * cache_unit();
    }
    return samples;
}

/// Adds to a count of the state, threads of a subgroup together.
void count_in_cache(uint word, uint n) {
    const uint sum = subgroupAdd(n);
    if (!subgroupElect() || sum == 0u) return;
    const uint before = atomicAdd(cache_state[word], sum);
    if (before + sum < before) atomicAdd(cache_state[word + 1u], 1u);
}

#endif
