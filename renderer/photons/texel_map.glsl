// GLSL twin of photons/texel_map.h: whose a texel of the lights' map is, and where its light path starts.
//
// Define TEXEL_RUNS_BINDING (of set 0) before.
#ifndef PHOTOND_TEXEL_MAP_GLSL
#define PHOTOND_TEXEL_MAP_GLSL

#include "renderer/core/hilbert.glsl"
#include "renderer/photons/photon_shared.h"
#include "renderer/photons/texel_map_shared.h"
#include "renderer/transport/emission_sampling.glsl"
#include "renderer/transport/sobol.glsl"

layout(set = 0, binding = TEXEL_RUNS_BINDING, scalar) readonly buffer TexelRuns { TexelRun texel_runs[]; };

const uint TEXEL_JITTER_SET = 0x80000000u;  // kJitterSet
const float TEXEL_PLACE_CELLS = float(1 << HILBERT_LEVELS);

/// The place in the unit square that texel `j` of `n` (up to 2^20) has at `u_jitter`.
vec2 place_in_square(uint j, uint n, vec2 u_jitter) {
    const uvec2 jitter = uvec2(u_jitter * TEXEL_PLACE_CELLS);
    const uint64_t jittered = uint64_t(j) << (2 * HILBERT_LEVELS) | uint64_t(jitter.x) << HILBERT_LEVELS |
                              uint64_t(jitter.y);
    return (vec2(hilbert_cell(jittered / uint64_t(n))) + 0.5) * (1.0 / TEXEL_PLACE_CELLS);
}

/// The texel of n whose part of the square holds that place.
uint texel_at_place(vec2 place, uint n) {
    return uint(hilbert_place(uvec2(place * TEXEL_PLACE_CELLS)) * uint64_t(n) >> (2 * HILBERT_LEVELS));
}

/// The run of `runs` that a texel belongs to.
TexelRun texel_run(uint texel, uint runs) {
    uint low = 0, high = runs;  // the last whose first texel is at or before this one
    while (high - low > 1) {
        const uint middle = (low + high) / 2;
        if (texel_runs[middle].first_texel <= texel) low = middle; else high = middle;
    }
    return texel_runs[low];
}

/// TexelMapPass::sample() with the texel's own numbers.
bool start_at_texel(uint texel, uint runs, SequenceKey sequence, out EmissionSample start) {
    const TexelRun run = texel_run(texel, runs);
    const uint64_t element = uint64_t(texel);
    const vec2 place = place_in_square(texel - run.first_texel, run.texels,
                                       sequence_sample_2d(sequence, element, TEXEL_JITTER_SET));
    vec2 u_position = sequence_sample_2d(sequence, element, PHOTON_SET_POSITION);
    vec2 u_direction = sequence_sample_2d(sequence, element, PHOTON_SET_DIRECTION);
    if (emission_guided_by_position(run.light)) u_position = place; else u_direction = place;
    return sample_emission_light(run.light, run.expected, u_position, u_direction, start);
}

#endif
