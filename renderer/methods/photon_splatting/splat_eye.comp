#version 460
// Visible points and direct light, a thread a pixel: CPU twin SpecularWalk::trace_tile(). A group takes a tile and goes from
// vertex to vertex together; what its paths leave at one vertex lies side by side and is one cluster.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/methods/photon_splatting/splat_shared.h"
#define IMAGE_BINDING 0
#define COUNTERS_BINDING 1
#define EYE_BINDING 2
#define SAMPLER_BINDING 3
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/eye/specular_walk.glsl"

layout(set = 0, binding = 4, scalar) readonly buffer Constants { SplatConstants constants; };
layout(set = 0, binding = 5, scalar) buffer Sizes { uint counts[SPLAT_COUNTS]; };
layout(set = 0, binding = 6, scalar) writeonly buffer Heads { uint first_of_pixel[]; };
layout(set = 0, binding = 7, scalar) writeonly buffer Points { SplatPoint points[]; };
layout(set = 0, binding = 8, scalar) writeonly buffer GeneralPoints { GBufferGeneral general_points[]; };
layout(set = 0, binding = 9, scalar) writeonly buffer Sums { SplatSum sums[]; };
layout(set = 0, binding = 10, scalar) writeonly buffer Clusters { SplatCluster clusters[]; };

layout(local_size_x = EYE_TILE * EYE_TILE) in;
layout(push_constant, scalar) uniform Push { SplatEyePush push; };

shared uint waiting[2];  // a bit a thread
shared uint walking_on;
shared uint first_point;

void keep_point(uint index, WalkVertex met, uint pixel, uint next) {
    SplatPoint point;
    point.position = met.surface.position;
    point.pixel = pixel;
    point.next = next;
    point.geometric_normal = met.surface.geometric_normal;
    point.splat_radius_m = 0.0;
    point.kind = eye.max_scatterings - min(eye.max_scatterings, met.scatterings + 1);
    if (bsdf_is_lambert(met.rough)) {
        point.normal = met.surface.shading.normal;
        point.weight = met.throughput * met.rough.diffuse * INV_PI;
    } else {
        point.normal = bsdf_has_non_delta_transmission(met.rough) ? vec3(0.0) : met.surface.shading.normal;
        point.weight = met.throughput;
        point.kind |= POINT_GENERAL;
        general_points[index] =
            GBufferGeneral(met.hit.t, met.hit.instance, met.hit.triangle, met.hit.u, met.hit.v, met.ray_direction,
                           met.outside_ior, met.media.materials);
    }
    points[index] = point;
    sums[index] = SplatSum(vec3(0.0), 0.0, 0.0);
}

void main() {
    const uint thread = gl_LocalInvocationIndex;
    const uint tile = push.first_tile + flat_index() / (EYE_TILE * EYE_TILE);
    uint pixel = 0;
    const bool seen = tile < push.end_tile && pixel_of_tile(tile, thread, pixel);
    EyePath path;
    Ray ray;
    uint key;
    start_eye_path(pixel, path, ray, key);
    PathLight light = no_light();
    uint vertices = 0, shadow_rays = 0, head = NO_POINT;
    bool walking = seen;
    for (bool group_walks = true; group_walks; group_walks = walking_on != 0) {
        barrier();  // all have read what the last vertex left
        if (thread == 0) waiting[0] = waiting[1] = walking_on = 0;
        barrier();
        WalkVertex met;
        bool waits = false;
        if (walking) {
            walking = walk_vertex(vertices, key, constants.glossy_threshold, path, ray, light, shadow_rays, met);
            waits = met.waits;
            ++vertices;
            if (waits) atomicOr(waiting[thread / 32], 1u << thread % 32);
            if (walking) atomicOr(walking_on, 1u);
        }
        barrier();
        const uvec2 mask = uvec2(waiting[0], waiting[1]);
        const uint total = bitCount(mask.x) + bitCount(mask.y);
        if (thread == 0 && total > 0) {
            first_point = atomicAdd(counts[SPLAT_COUNT_POINTS], total);
            const uint cluster = atomicAdd(counts[SPLAT_COUNT_CLUSTERS], 1u);
            if (cluster < constants.cluster_capacity && first_point + total <= constants.point_capacity)
                clusters[cluster] = SplatCluster(vec3(0.0), 0.0, vec3(0.0), 0.0, vec3(0.0), first_point, total, 0);
        }
        barrier();
        if (waits && first_point + total <= constants.point_capacity) {
            const uint below = (1u << thread % 32) - 1u;
            const uint place = thread < 32 ? bitCount(mask.x & below) : bitCount(mask.x) + bitCount(mask.y & below);
            keep_point(first_point + place, met, pixel, head);
            head = first_point + place;
        }
    }
    if (seen) {
        store_light(pixel, light);
        first_of_pixel[pixel] = head;
        count(COUNTER_CAMERA_RAYS, 1);
        count(COUNTER_BOUNCE_RAYS, vertices - 1);
        count(COUNTER_SHADOW_RAYS, shadow_rays);
    }
}
