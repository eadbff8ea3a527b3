#version 460
// Adds a batch's splats to the visible points of a cluster: CPU twins VisibleClusters::find() and SplatAccumulator. A group
// a cluster, a thread a point. The group's threads test as many splats at once against the cluster's bounds; those that
// may reach it wait in shared memory, in their order, and are then gone through by all threads together. So nothing is
// written down of which splat reaches which cluster, every sum is taken in the order of the splats, and what is tested in
// vain costs about as much as a fifth of the lighting: in a room a splat reaches one cluster in twenty, of 64 points.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define COUNTERS_BINDING 0
#include "renderer/backends/gpu/counters.glsl"
#include "renderer/backends/gpu/invocation.glsl"
#define DEPTH_MAPS_BINDING 7
#include "renderer/many_lights/vpl.glsl"
#include "renderer/methods/photon_splatting/splat_depth_maps.glsl"
#include "renderer/methods/photon_splatting/splat_gain.glsl"
#include "renderer/gbuffer/receiver.glsl"
#include "renderer/photons/photon.glsl"
#include "renderer/photons/reflected_photon_shared.h"
#include "renderer/transport/photon_scattering.glsl"

layout(constant_id = SPLAT_HAS_CONNECTIONS_ID) const bool SPLAT_HAS_CONNECTIONS = true;
layout(constant_id = SPLAT_HAS_BEAMS_ID) const bool SPLAT_HAS_BEAMS = true;
layout(constant_id = SPLAT_NORMALISED_ID) const bool SPLAT_NORMALISED = false;
layout(constant_id = SPLAT_VISIBILITY_ID) const bool SPLAT_VISIBILITY = true;

layout(local_size_x = SPLAT_GROUP) in;
layout(push_constant, scalar) uniform Push { SplatClusterPush push; };
layout(set = 0, binding = 1, scalar) readonly buffer Constants { SplatConstants constants; };
layout(set = 0, binding = 2, scalar) readonly buffer Sizes { uint counts[SPLAT_COUNTS]; };
layout(set = 0, binding = 3, scalar) readonly buffer Clusters { SplatCluster clusters[]; };
layout(set = 0, binding = 4, scalar) readonly buffer Points { SplatPoint points[]; };
layout(set = 0, binding = 5, scalar) readonly buffer GeneralPoints { GBufferGeneral general_points[]; };
layout(set = 0, binding = 6, scalar) readonly buffer Splats { Splat splats[]; };
layout(set = 0, binding = 8, scalar) readonly buffer Surfaces { ReflectingSurfaceRecord surfaces[]; };
layout(set = 0, binding = 9, scalar) buffer Sums { SplatSum sums[]; };

shared uint found[2];  // a bit a thread: its splat may reach the cluster
shared uint queue[2 * SPLAT_GROUP];  // splats; above them, at QUEUE_BLOCKERS_SHIFT, what shaft_blockers() says of each
const uint QUEUE_BLOCKERS_SHIFT = 28, QUEUE_SPLAT = (1u << QUEUE_BLOCKERS_SHIFT) - 1u;
#define SHAFT_MOST_BLOCKERS 8
shared uint blockers[2 * SPLAT_GROUP * SHAFT_MOST_BLOCKERS];
#define SHAFT_BLOCKERS blockers
#include "renderer/transport/shaft_visibility.glsl"

uint contributions = 0, shadow_rays = 0;

/// Whether the splat may light points of the cluster.
bool may_light(Splat splat, SplatCluster cluster) {
    const uint kind = splat.kind & SPLAT_KIND_MASK;
    if (kind == SPLAT_NONE || splat.kind >> SPLAT_SCATTERINGS_SHIFT > cluster.most_scatterings) return false;
    const bool beam = SPLAT_HAS_BEAMS && (!SPLAT_HAS_CONNECTIONS || kind == SPLAT_BEAM);
    const vec3 d = cluster.centre - splat.origin;
    const vec3 across = d - clamp(dot(d, splat.axis), splat.near_m, splat.far_m) * splat.axis;
    const float reach = cluster.radius_m + splat.radius * (beam ? 1.0 : cluster.splat_radius_m);
    if (dot(across, across) > sqr(reach)) return false;
    const bool flat_points = cluster.normal != vec3(0.0);
    if (beam) return !flat_points || dot(cluster.normal, splat.axis) < 0.0;
    // All below the horizon of y, or so little above that next to nothing gets there.
    if (dot(splat.normal, d) + dot(abs(splat.normal), cluster.half_extent) <= 1e-5 * constants.radius_m) return false;
    return !flat_points || dot(abs(cluster.normal), cluster.half_extent) > dot(cluster.normal, d);
}

/// Whether anything stands between the point and the splat's origin.
bool cut_off(uint place, Splat splat, SplatPoint point) {
    const uint count = queue[place] >> QUEUE_BLOCKERS_SHIFT;
    if (count == 0) return false;
    const bool front = dot(point.geometric_normal, splat.origin - point.position) > 0.0;
    const vec3 from = offset_ray_origin(point.position, front ? point.geometric_normal : -point.geometric_normal);
    const vec3 side = dot(splat.normal, splat.axis) < 0.0 ? -splat.normal : splat.normal;
    const vec3 to = offset_ray_origin(splat.origin, side);
    if (count <= SHAFT_MOST_BLOCKERS) return shaft_cut(place, count, from, to);
    ++shadow_rays;
    return occluded(Ray(from, to - from, kConnectionEnd));
}

/// The splat's intensity towards a point, `d` from its origin: intensity_towards() of splat_accumulation.cpp.
vec3 intensity_towards(Splat splat, vec3 d) {
    const bool rough = !ONLY_LAMBERT && (splat.kind & SPLAT_KIND_MASK) == SPLAT_CONNECT_ROUGH;
    if (!rough && (splat.kind & SPLAT_CORRECTED) == 0) return splat.intensity;
    const vec3 w = d * (1.0 / length(d));
    if (!rough)
        return splat.intensity * (dot(octahedral_decode(16u, splat.smooth_normal), w) > 0.0 ? splat.correction : 1.0);
    // The gain holds cos / pi, as Lambert reflectors send it out.
    const float cosine = dot(splat.normal, w);
    if (!(cosine > 0.0)) return vec3(0.0);
    const ReflectingSurfaceRecord at = surfaces[splat.surface];
    const ShadingPoint surface = make_shading_point(Hit(at.t, at.instance, at.triangle, at.u, at.v), -at.wi_world);
    const Bsdf lobes = bsdf_rough_part(make_bsdf(surface, at.outside_ior), constants.photon_threshold);
    return splat.intensity * scatter_density(surface, lobes, at.wi_world, w) * (PI / cosine);
}

/// Adds one splat, at that place of the queue, to one point's sum.
void add_splat(uint place, Splat splat, SplatPoint point, Receiver receiver, inout SplatSum sum) {
    if (splat.kind >> SPLAT_SCATTERINGS_SHIFT > (point.kind & ~POINT_GENERAL)) return;
    const bool beam =
        SPLAT_HAS_BEAMS && (!SPLAT_HAS_CONNECTIONS || (splat.kind & SPLAT_KIND_MASK) == SPLAT_BEAM);
    const vec3 d = point.position - splat.origin;
    float gain;
    if (beam ? !beam_gain(splat, point, constants.kernel, gain) : !connect_gain(splat, point, constants.kernel, gain))
        return;
    ++contributions;
    if (SPLAT_VISIBILITY) {
        const uint side = constants.shadow_resolution;
        if (beam ? !reaches(queue[place], side, splat, d) : cut_off(place, splat, point)) return;
    }
    sum.splats += 1.0;
    vec3 light = gain * (beam ? splat.intensity : intensity_towards(splat, d));
    if (!is_general(point)) {
        sum.sum += light;
        // The filter's weight without the receiver's cosine.
        if (SPLAT_NORMALISED) sum.splat_weight += splat.weight * gain / -dot(point.normal, splat.axis);
        return;
    }
    if (SPLAT_NORMALISED) sum.splat_weight += splat.weight * gain;
    const vec3 from = beam ? -splat.axis : -d * (1.0 / length(d));
    sum.sum += bsdf_f_cos(receiver.rough, receiver.wo, to_local(receiver.surface.shading, from)) * light;
}

void light_cluster(SplatCluster cluster) {
    const uint thread = gl_LocalInvocationIndex;
    const bool mine = thread < cluster.points;
    const uint index = cluster.first_point + min(thread, cluster.points - 1);
    const SplatPoint point = points[index];
    Receiver receiver;
    if (mine && is_general(point)) receiver = make_receiver(general_points[index], constants.glossy_threshold);
    SplatSum sum = sums[index];

    uint waiting = 0;
    for (uint first = push.first_splat; first < push.end_splat; first += SPLAT_GROUP) {
        if (thread < 2) found[thread] = 0;
        barrier();
        const bool reached = first + thread < push.end_splat && may_light(splats[first + thread], cluster);
        if (reached) atomicOr(found[thread / 32], 1u << thread % 32);
        barrier();
        const uvec2 mask = uvec2(found[0], found[1]);
        const uint below = (1u << thread % 32) - 1u;
        const uint place = thread < 32 ? bitCount(mask.x & below) : bitCount(mask.x) + bitCount(mask.y & below);
        if (reached) queue[waiting + place] = first + thread;
        waiting += bitCount(mask.x) + bitCount(mask.y);
        barrier();
        const bool last = first + SPLAT_GROUP >= push.end_splat;
        if (waiting < SPLAT_GROUP && !last) continue;
        if (SPLAT_VISIBILITY && SPLAT_HAS_CONNECTIONS) {
            const ShaftTarget target =
                ShaftTarget(cluster.centre, cluster.half_extent, cluster.radius_m, cluster.normal);
            for (uint i = thread; i < waiting; i += SPLAT_GROUP) {
                const Splat splat = splats[queue[i]];
                if ((splat.kind & SPLAT_KIND_MASK) != SPLAT_BEAM)
                    queue[i] |= shaft_blockers(splat.origin, splat.normal, target, i) << QUEUE_BLOCKERS_SHIFT;
            }
            barrier();
        }
        if (mine)
            for (uint i = 0; i < waiting; ++i) add_splat(i, splats[queue[i] & QUEUE_SPLAT], point, receiver, sum);
        waiting = 0;
        barrier();
    }
    if (mine) sums[index] = sum;
    count(COUNTER_SPLAT_CONTRIBUTIONS, contributions);
    count(COUNTER_SHADOW_RAYS, shadow_rays);
}

void main() {
    const uint index = push.first_cluster + flat_index() / SPLAT_GROUP;
    if (index < min(push.end_cluster, counts[SPLAT_COUNT_CLUSTERS])) light_cluster(clusters[index]);
}
