#version 460
// Light paths and what they leave where they are reflected, a thread a path, with the same numbers as CPU twin
// photon_reflections.cpp.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define COUNTERS_BINDING 0
#include "renderer/backends/gpu/counters.glsl"
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/photons/reflected_photons.glsl"
#include "renderer/transport/roulette_shared.h"

layout(local_size_x = REFLECTION_GROUP) in;
layout(push_constant, scalar) uniform Push { ReflectionPush push; };
layout(set = 0, binding = 6, scalar) readonly buffer Grids { TexelGrid grids[]; };

/// Twin: ReflectiveShadowMapPass::sample().
bool start_at_texel(uint texel, uint64_t element, out EmissionSample start) {
    uint low = 0, high = push.grids;  // the last grid whose first texel is at or before this one
    while (high - low > 1) {
        const uint middle = (low + high) / 2;
        if (grids[middle].first_texel <= texel) low = middle; else high = middle;
    }
    const TexelGrid grid = grids[low];
    const uint place = texel - grid.first_texel;
    const vec2 u_jitter = sequence_sample_2d(push.sequence, element, JITTER_SET);
    vec2 u_position = sequence_sample_2d(push.sequence, element, PHOTON_SET_POSITION);
    vec2 u_direction = sequence_sample_2d(push.sequence, element, PHOTON_SET_DIRECTION);
    const vec2 cell = vec2(place % grid.columns, place / grid.columns);  // into_cell() of emission_grid.h
    const vec2 in_cell = min((cell + u_jitter) * (1.0 / vec2(grid.columns, grid.rows)), vec2(BELOW_ONE));
    if (emission_guided_by_position(grid.light)) u_position = in_cell; else u_direction = in_cell;
    return sample_emission_light(grid.light, grid.expected, u_position, u_direction, start);
}

void trace_path(uint number) {
    const uint64_t element = push.first_element + uint64_t(number);
    EmissionSample start;
    const bool carries =
        push.grids > 0 ? start_at_texel(number, element, start) : draw_emission(push.sequence, element, start);
    PhotonPath path;
    uint rays = 0;
    if (carries && start_photon_path(start, push.share, path))
        rays = follow_reflections(number, push.sequence, element, ROULETTE_MOST_SURVIVAL, start, path);
    count(COUNTER_PHOTON_RAYS, rays);
    count(COUNTER_PHOTONS_EMITTED, 1);
    count(COUNTER_PHOTONS_STORED, kept);
}

void main() {
    const uint number = push.first_path + flat_index();
    reflection = ReflectionLimits(push.most_scatterings, push.photon_capacity, push.surface_capacity,
                                  push.glossy_threshold, push.rough_apart != 0, true);
    if (number < push.end_path) {
        trace_path(number);
        end_reflections(number);
    }
}
