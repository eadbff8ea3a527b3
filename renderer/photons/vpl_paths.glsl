// The light paths of chosen texels and what they leave, a thread a path: the whole of a shader but its first lines. CPU
// twin: VplTracer::trace() and photon_wavefront_reflections.cpp.
//
// A shader that finds the hits after the first in its own way defines PHOTON_LATER_HIT (photon_paths.glsl) before, and
// has its bindings from VPL_BOUNCE_BINDING on.
#ifndef PHOTOND_VPL_PATHS_GLSL
#define PHOTOND_VPL_PATHS_GLSL

#define COUNTERS_BINDING 0
#define TEXEL_RUNS_BINDING 6
#define FLUX_SUMS_BINDING 7
#include "renderer/backends/gpu/counters.glsl"
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/photons/flux_map.glsl"
#include "renderer/photons/reflected_photons.glsl"
#include "renderer/photons/texel_map.glsl"
#include "renderer/photons/vpl_tracer_shared.h"

layout(local_size_x = VPL_GROUP) in;
layout(push_constant, scalar) uniform Push { VplPathsPush push; };
layout(set = 0, binding = 8, scalar) readonly buffer Flux { float flux_w[]; };  // of texels, by the plain pyramid
layout(set = 0, binding = 9, scalar) readonly buffer Points { uint points[]; };  // by texel

void trace_path(uint number) {
    const uint point = points[number];
    const Texel texel =
        flux_choose(push.levels, rotated_halton_point(point, uvec2(push.rotation_x, push.rotation_y)));
    const float share = 1.0 / (float(push.paths) * texel.probability);
    EmissionSample start;
    PhotonPath path;
    if (!start_at_texel(texel.index, push.runs, push.texel_sequence, start) || !start_photon_path(start, share, path))
        return;
    path.reference_inverse = 1.0 / (flux_w[texel.index] * share);
    count(COUNTER_PHOTON_RAYS, follow_reflections(number, push.sequence, uint64_t(point), 1.0, start, path));
}

void main() {
    const uint number = flat_index();
    reflection =
        ReflectionLimits(push.bounces, push.paths * push.bounces, push.surface_capacity, push.glossy_threshold, true, false);
    if (number >= push.paths) return;
    if (flux_total(push.levels) > 0.0) trace_path(number);
    count(COUNTER_PHOTONS_EMITTED, 1);
    count(COUNTER_PHOTONS_STORED, kept);
    end_reflections(number);
}

#endif
