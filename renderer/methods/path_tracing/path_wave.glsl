// Paths of the wavefront as they wait between its kernels. [Laine, Karras, Aila 2013] Megakernels Considered Harmful:
// Wavefront Path Tracing on GPUs. HPG. Paths stay in their places; queues hold the places of those under way. Which path
// is where in a queue differs from run to run, what is added to a pixel and in which order does not.
#ifndef PHOTOND_PATH_WAVE_GLSL
#define PHOTOND_PATH_WAVE_GLSL

#extension GL_KHR_shader_subgroup_ballot : require

#define IMAGE_BINDING 0
#define COUNTERS_BINDING 1
#define EYE_BINDING 2
#define SAMPLER_BINDING 3
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/methods/path_tracing/path_step.glsl"
#include "renderer/methods/path_tracing/path_tracing_shared.h"

layout(local_size_x = PATH_QUEUE_GROUP) in;
layout(push_constant, scalar) uniform Push { PathWavePush push; };

// A multiple of the capacity: two queues of places.
layout(set = 0, binding = 4, scalar) buffer PathCounts { uint path_counts[]; };
layout(set = 0, binding = 5, scalar) buffer PathQueues { uint path_queues[]; };
layout(set = 0, binding = 6, scalar) buffer PathStates { PathState path_states[]; };
layout(set = 0, binding = 7, scalar) buffer PathHits { Hit path_hits[]; };
layout(set = 0, binding = 8, scalar) buffer PathShadows { ShadowState path_shadows[]; };

PathState pack_path(EyePath path, Ray ray, uint key) {
    PathState s;
    s.throughput = path.throughput, s.pdf_sa = path.pdf_sa;
    s.position = path.position, s.eta_scale = path.eta_scale;
    s.lit_normal = path.lit_normal, s.pixel = path.pixel;
    s.origin = ray.origin, s.key = key, s.direction = ray.direction;
    s.flags = path.scatterings | (path.delta ? PATH_DELTA : 0u) | (path.caustic ? PATH_CAUSTIC : 0u);
    s.media[0] = path.media.materials.x, s.media[1] = path.media.materials.y;
    s.media[2] = path.media.materials.z, s.media[3] = path.media.materials.w;
    return s;
}

EyePath unpack_path(PathState s) {
    EyePath path;
    path.throughput = s.throughput, path.pdf_sa = s.pdf_sa;
    path.position = s.position, path.eta_scale = s.eta_scale;
    path.lit_normal = s.lit_normal, path.pixel = s.pixel;
    path.scatterings = s.flags & ~(PATH_DELTA | PATH_CAUSTIC);
    path.delta = (s.flags & PATH_DELTA) != 0, path.caustic = (s.flags & PATH_CAUSTIC) != 0;
    path.media = MediumStack(NEEDS_SOLID_GLASS ? uvec4(s.media[0], s.media[1], s.media[2], s.media[3]) : uvec4(VACUUM));
    return path;
}

Ray ray_of(PathState s) { return Ray(s.origin, s.direction, INFINITY); }

/// A place in the queue of that count: one atomic operation for the threads of a subgroup that ask together.
uint take_place(uint queue_count) {
    const uvec4 asking = subgroupBallot(true);
    uint first = 0;
    if (subgroupElect()) first = atomicAdd(path_counts[queue_count], subgroupBallotBitCount(asking));
    return subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(asking);
}

/// The place of the path this thread has; false past the queue's end.
bool queued_path(out uint place) {
    const uint i = flat_index();
    const bool there = i < path_counts[PATHS_NOW];
    place = there ? path_queues[push.odd * push.capacity + i] : 0;
    return there;
}

#endif
