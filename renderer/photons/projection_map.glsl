// GLSL twin of photons/projection_map.h: light paths that start where the lights see specular surfaces. Define
// GUIDE_WORDS_BINDING and GUIDE_FLOATS_BINDING (of set 0) before: ProjectionMap::device_tables(), or anything where
// GUIDED is false.
#ifndef PHOTOND_PROJECTION_MAP_GLSL
#define PHOTOND_PROJECTION_MAP_GLSL

#include "renderer/photons/projection_map_shared.h"
#include "renderer/transport/discrete_distribution.glsl"
#include "renderer/transport/emission_sampling.glsl"

layout(constant_id = GUIDED_ID) const bool GUIDED = false;

layout(set = 0, binding = GUIDE_WORDS_BINDING, scalar) readonly buffer GuideWords { uint guide_words[]; };
layout(set = 0, binding = GUIDE_FLOATS_BINDING, scalar) readonly buffer GuideFloats { float guide_cdf[]; };

DISCRETE_DISTRIBUTION(guide_choice, guide_cdf, guide_words)

bool guided() { return GUIDED; }

/// u in that cell of a square of count x count; stays below 1. Twin: emission_grid.h.
vec2 into_cell(uvec2 cell, uint count, vec2 u) {
    const float below_one = 0.999999940395355224609375;
    return min((vec2(cell) + u) * (1.0 / float(count)), vec2(below_one));
}

/// The grid that holds the bin: the last that begins at it or before. Where its words are.
uint guide_grid_of(uint bin) {
    uint low = 0, high = guide_words[GUIDE_GRIDS];
    while (high - low > 1) {
        const uint middle = (low + high) / 2;
        if (guide_words[GUIDE_HEADER + GUIDE_GRID * middle + GUIDE_GRID_FIRST_BIN] <= bin) low = middle; else high = middle;
    }
    return GUIDE_HEADER + GUIDE_GRID * low;
}

/// As sample_emission(), preferring the bins that saw specular surfaces; the power makes up for it.
bool projection_map_sample(float u_select, vec2 u_position, vec2 u_direction, out EmissionSample emission) {
    const uint guide = guide_words[GUIDE_CHOICE], guided_bins = guide_words[GUIDE_BINS];
    const uint bin = guide_choice_sample(0u, guide, guide_words[GUIDE_CHOICES], u_select);
    const float probability = guide_choice_probability(0u, bin);
    if (bin >= guided_bins) {
        const uint light = guide_words[guide_words[GUIDE_REST] + bin - guided_bins];
        return sample_emission_light(light, probability, u_position, u_direction, emission);
    }
    const uint grid = guide_grid_of(bin);
    const uint index = bin - guide_words[grid + GUIDE_GRID_FIRST_BIN];
    const uint p = guide_words[grid + GUIDE_GRID_PLACES], d = guide_words[grid + GUIDE_GRID_DIRECTIONS];
    const uvec2 place = uvec2(index / (d * d) % p, index / (d * d * p)), direction = uvec2(index % d, index / d % d);
    return sample_emission_light(guide_words[grid + GUIDE_GRID_LIGHT], probability * float(p * p * d * d),
                                 into_cell(place, p, u_position), into_cell(direction, d, u_direction), emission);
}

#endif
