// Paths of a wavefront as they wait between its kernels. [Laine, Karras, Aila 2013] Megakernels Considered Harmful:
// Wavefront Path Tracing on GPUs. HPG. What is added to a pixel, and in which order, is the same from run to run.
//
// Define PATH_WAVE_TAIL before where paths are followed to their ends: what waits for other kernels is left out.
#ifndef PHOTOND_PATH_WAVE_GLSL
#define PHOTOND_PATH_WAVE_GLSL

#define IMAGE_BINDING 0
#define COUNTERS_BINDING 1
#define EYE_BINDING 2
#define SAMPLER_BINDING 3
#define WAVE_QUEUES_BINDING 4
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/eye/eye_vertex.glsl"
#include "renderer/eye/path_state.glsl"
#include "renderer/eye/wave_queues.glsl"

layout(local_size_x = WAVE_GROUP) in;
layout(push_constant, scalar) uniform Push { PathWavePush push; };

layout(set = 0, binding = 5, scalar) buffer PathStates { PathState path_states[]; };
#ifndef PATH_WAVE_TAIL
layout(set = 0, binding = 6, scalar) buffer PathHits { Hit path_hits[]; };
layout(set = 0, binding = 7, scalar) buffer PathShadows { ShadowState path_shadows[]; };

/// A light sample of that pixel waits for its shadow ray.
void add_shadow(PendingLight pending, uint pixel) {
    ShadowState shadow;
    shadow.origin = pending.ray.origin, shadow.direction = pending.ray.direction, shadow.t_max = pending.ray.t_max;
    shadow.pixel = pixel, shadow.radiance = pending.radiance, shadow.indirect = pending.indirect ? 1 : 0;
    path_shadows[take_place(WAVE_SHADOWS)] = shadow;
}
#endif

/// The place of the path this thread has; false past the queue's end.
bool queued_path(out uint place) {
    const uint i = flat_index();
    const bool there = i < wave_queues[WAVE_NOW(WAVE_PATHS)];
    place = there ? wave_queues[WAVE_COUNT_WORDS + push.odd * push.capacity + i] : 0;
    return there;
}

/// The path goes on.
void keep_path(uint place, EyePath path, Ray ray, uint key) {
    path_states[place] = pack_path(path, ray, key);
    wave_queues[WAVE_COUNT_WORDS + (1 - push.odd) * push.capacity + take_place(WAVE_PATHS)] = place;
}

#endif
