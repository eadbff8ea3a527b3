#version 460
// Light paths and the photons they leave: a thread follows a path to its end, then takes the next one, so that the threads
// that run together all have something to follow. CPU twin: PhotonArrivals::trace(), with the same numbers. Photons are
// appended as they come, under the number of their path; sorting by it (photon_tracer_gpu.h) brings them into one order,
// as those of one path come in the order of its scatterings.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require

#define GUIDE_WORDS_BINDING 6
#define GUIDE_FLOATS_BINDING 7
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/photons/photon.glsl"
#include "renderer/photons/photon_paths.glsl"
#include "renderer/photons/photon_tracing_shared.h"

layout(local_size_x = PHOTON_TRACING_GROUP) in;
layout(push_constant, scalar) uniform Push { PhotonTracingPush push; };
layout(set = 0, binding = 0, scalar) buffer State { uint state[PHOTON_STATE_WORDS]; };
layout(set = 0, binding = 1, std430) writeonly buffer Places { uvec4 places[]; };  // PhotonPlace
layout(set = 0, binding = 2, std430) writeonly buffer Powers { uvec4 powers[]; };  // PhotonPower
layout(set = 0, binding = 3, scalar) writeonly buffer Paths { uint paths[]; };
layout(set = 0, binding = 4, scalar) writeonly buffer Order { uint order[]; };
layout(set = 0, binding = 5, scalar) readonly buffer Stores { uint instance_stores[]; };  // 1: may be diffuse
layout(set = 0, binding = 8, scalar) readonly buffer FirstHits { FirstHit first_hits[]; };  // BOUNCE_MAP

layout(constant_id = BOUNCE_MAP_ID) const bool BOUNCE_MAP = false;

#include "renderer/photons/photon_ray_count.glsl"

uint photon_rays = 0;

/// Where a path is, and what it is to be told from others by.
struct Walk {
    PhotonPath path;
    Ray ray;
    float range_m;
    uint number;  // of the pass
    Hit first;    // BOUNCE_MAP: of its first ray
};

/// From where light first arrives. Photons of one number modulo that of texels leave from the same.
bool start_from_bounce_map(uint number, out Walk walk) {
    const uint texel = number % push.texels;
    const FirstHit from = first_hits[texel];
    walk.ray = Ray(vec3(0.0), from.ray_direction, INFINITY);
    walk.range_m = INFINITY;
    walk.number = number;
    walk.first = Hit(from.t, from.instance, from.triangle, from.u, from.v);
    const uint sharing = push.photons / push.texels + (texel < push.photons % push.texels ? 1u : 0u);
    EmissionSample start;
    start.power_w = from.power_w;
    if (!start_photon_path(start, 1.0 / (float(push.texels) * float(sharing)), walk.path)) return false;
    walk.path.power_w *= from.arriving;
    return hit_valid(walk.first) && from.arriving > 0.0;
}

bool start_walk(uint number, out Walk walk) {
    if (BOUNCE_MAP) return start_from_bounce_map(number, walk);
    EmissionSample start;
    const bool carries = draw_emission(push.sequence, push.first_element + uint64_t(number), start);
    walk.ray = start.ray;
    walk.range_m = start.range_m;
    walk.number = number;
    const bool starts = start_photon_path(start, 1.0 / float(push.photons), walk.path);
    return carries && starts;
}

void store(Walk walk, PhotonVertex vertex) {
    const uint place = atomicAdd(state[PHOTONS_STORED_WORD], 1u);
    if (place >= push.capacity) return;
    const bool marked = is_marked_photon(uint(push.first_element) + walk.number, walk.path.scatterings);
    const uint packed =
        pack_normal_and_path(vertex.point.geometric_normal, walk.path.scatterings, walk.path.all_delta, marked);
    places[place] = uvec4(floatBitsToUint(vertex.point.position), packed);
    powers[place] = uvec4(floatBitsToUint(walk.path.power_w), pack_photon_direction(vertex.wi_world));
    paths[place] = walk.number;
    order[place] = place;
}

/// To the next surface, where the photon may be stored, and on. False: the path ends. Twin:
/// PhotonWavefront::scatter_general().
bool step_walk(inout Walk walk) {
    Hit hit = walk.first;
    if (!BOUNCE_MAP || walk.path.scatterings > 0) {
        ++photon_rays;
        if (!follow_photon(walk.path, walk.ray, walk.range_m, hit)) return false;
    }
    PhotonVertex vertex;
    if (!part_hit(walk.path, hit, walk.ray.direction, push.glossy_threshold, vertex)) return false;
    const bool caustic = push.kind == PHOTON_MAP_CAUSTIC;
    const uint scatterings = walk.path.scatterings;
    if ((caustic ? scatterings > 0 : walk.path.rough) &&
        (bsdf_scatters(vertex.rough) || instance_stores[hit.instance] != 0))
        store(walk, vertex);
    if (scatterings >= push.most_scatterings) return false;
    const PhotonNumbers numbers =
        photon_numbers(push.sequence, push.first_element + uint64_t(walk.number), scatterings);
    bool is_rough;
    return scatter_parted(vertex, numbers, !caustic, walk.path, walk.ray, is_rough);
}

void main() {
    Walk walk;
    uint next = push.first_path + flat_index();
    bool alive = false;
    while (true) {
        while (!alive && next < push.end_path) {
            alive = start_walk(next, walk);
            next = push.first_path + push.threads + atomicAdd(state[NEXT_PATH_WORD], 1u);
        }
        if (!alive) break;
        alive = step_walk(walk);
    }
    if (photon_nan_samples > 0) atomicAdd(state[NAN_SAMPLES_WORD], photon_nan_samples);
    if (photon_infinite_samples > 0) atomicAdd(state[INFINITE_SAMPLES_WORD], photon_infinite_samples);
    const uint rays = subgroupAdd(photon_rays);
    if (subgroupElect() && rays > 0) add_photon_rays(rays);
}
