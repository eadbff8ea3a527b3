#version 460
// How wide splats are at each visible point, and what bounds a cluster's points: CPU twins SplatSizes::radius_m() and
// ClusterBuilder::add_cluster(). A group a cluster.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/core/geometry.glsl"
#include "renderer/methods/photon_splatting/splat_shared.h"

layout(set = 0, binding = 0, scalar) readonly buffer Constants { SplatConstants constants; };
layout(set = 0, binding = 1, scalar) readonly buffer Sizes { uint counts[SPLAT_COUNTS]; };
layout(set = 0, binding = 2, scalar) readonly buffer SizeFactors { float size_factors[]; };
layout(set = 0, binding = 3, scalar) buffer Points { SplatPoint points[]; };
layout(set = 0, binding = 4, scalar) buffer Clusters { SplatCluster clusters[]; };

layout(local_size_x = SPLAT_GROUP) in;
#include "renderer/backends/gpu/invocation.glsl"
layout(push_constant, scalar) uniform Push { SplatClusterPush push; };

#define BOX_GROUP SPLAT_GROUP
#include "renderer/splats/box_of_group.glsl"
shared vec4 mean_and_radius[SPLAT_GROUP];
shared uint most_scatterings;
shared uint uneven;

float splat_radius_m(vec3 p, vec3 n) {
    if (constants.sizes_cells.x == 0) return constants.radius_m;
    // In front of the surface, not within it.
    const vec3 place = (p + constants.sizes_cell_m * n - constants.sizes_low) / constants.sizes_cell_m;
    const uvec3 cell = uvec3(clamp(place, vec3(0.0), vec3(constants.sizes_cells) - 1.0));
    const uvec3 cells = constants.sizes_cells;
    return constants.radius_m * size_factors[(cell.z * cells.y + cell.y) * cells.x + cell.x];
}

/// Normals of coplanar triangles, which differ by rounding.
bool alike(vec3 a, vec3 b) { return dot(a - b, a - b) < 1e-12; }

void main() {
    const uint index = push.first_cluster + flat_index() / SPLAT_GROUP;
    if (index >= min(push.end_cluster, min(counts[SPLAT_COUNT_CLUSTERS], constants.cluster_capacity))) return;
    const uint thread = gl_LocalInvocationIndex;
    SplatCluster cluster = clusters[index];
    // Threads past the cluster's points stand for its last one.
    const SplatPoint point = points[cluster.first_point + min(thread, cluster.points - 1)];
    const vec3 normal = points[cluster.first_point].geometric_normal;
    const float radius_m = splat_radius_m(point.position, point.geometric_normal);
    if (thread < cluster.points) points[cluster.first_point + thread].splat_radius_m = radius_m;

    if (thread == 0) uneven = most_scatterings = 0;
    vec3 box_low = point.position, box_high = point.position;
    box_of_group(box_low, box_high);
    mean_and_radius[thread] = vec4(thread < cluster.points ? point.position : vec3(0.0), radius_m);
    barrier();
    for (uint step = SPLAT_GROUP / 2; step > 0; step /= 2) {
        if (thread < step) {
            const vec4 other = mean_and_radius[thread + step];
            mean_and_radius[thread] = vec4(mean_and_radius[thread].xyz + other.xyz, max(mean_and_radius[thread].w, other.w));
        }
        barrier();
    }
    const vec3 mean = mean_and_radius[0].xyz / float(cluster.points);
    const float splat_radius = mean_and_radius[0].w;
    const float scale = max_component(max(abs(box_low), abs(box_high)) + (box_high - box_low));
    if (!alike(point.geometric_normal, normal) || !alike(point.normal, normal) ||
        abs(dot(point.position - mean, normal)) > SPLAT_OFF_PLANE * scale)
        atomicOr(uneven, 1u);
    atomicMax(most_scatterings, point.kind & ~POINT_GENERAL);
    barrier();
    // The mean of points on a plane is on it, which the box's centre is not.
    const vec3 centre = uneven == 0 ? mean : 0.5 * (box_low + box_high);
    const vec3 from_centre = point.position - centre;
    barrier();
    mean_and_radius[thread].x = dot(from_centre, from_centre);
    barrier();
    for (uint step = SPLAT_GROUP / 2; step > 0; step /= 2) {
        if (thread < step) mean_and_radius[thread].x = max(mean_and_radius[thread].x, mean_and_radius[thread + step].x);
        barrier();
    }
    if (thread != 0) return;
    cluster.centre = centre;
    cluster.radius_m = sqrt(mean_and_radius[0].x) * 1.0001;
    cluster.half_extent = max(box_high - centre, centre - box_low);
    cluster.splat_radius_m = splat_radius;
    cluster.normal = uneven == 0 ? normal : vec3(0.0);
    cluster.most_scatterings = most_scatterings;
    clusters[index] = cluster;
}
