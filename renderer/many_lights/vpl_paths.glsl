// The light paths of chosen texels and what they leave, a thread a path: the whole of a shader but its first lines. CPU
// twin: VplTracer::trace() and photon_reflections.cpp.
//
// A shader that finds the hits after the first in its own way defines PHOTON_LATER_HIT (photon_paths.glsl) before, and
// has its bindings from VPL_BOUNCE_BINDING on.
#ifndef PHOTOND_VPL_PATHS_GLSL
#define PHOTOND_VPL_PATHS_GLSL

#define COUNTERS_BINDING 0
#include "renderer/backends/gpu/counters.glsl"
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/photons/reflected_photons.glsl"
#include "renderer/many_lights/vpl_tracer_shared.h"

layout(local_size_x = VPL_GROUP) in;
layout(push_constant, scalar) uniform Push { VplPathsPush push; };
layout(set = 0, binding = 6, scalar) readonly buffer Starts { VplStart starts[]; };

void trace_path(uint number) {
    const VplStart first = starts[number];
    const EmissionSample start =
        EmissionSample(Ray(first.origin, first.direction, INFINITY), first.power_w, 0u, 0u, first.range_m);
    PhotonPath path;
    if (!start_photon_path(start, 1.0, path)) return;
    path.reference_inverse = 1.0 / first.reflected_w;
    count(COUNTER_PHOTON_RAYS, follow_reflections(number, push.sequence, uint64_t(first.element), 1.0, start, path));
}

void main() {
    const uint number = flat_index();
    reflection =
        ReflectionLimits(push.bounces, push.photon_capacity, push.surface_capacity, push.connect_threshold, true, false);
    if (number >= min(push.paths, state[REFLECTION_PATHS])) return;
    trace_path(number);
    if (push.rated == 0u) {
        count(COUNTER_PHOTONS_EMITTED, 1);
        count(COUNTER_PHOTONS_STORED, kept);
    }
    end_reflections(number);
}

#endif
