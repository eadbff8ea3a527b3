#version 460
// The rays of the points that gather, GATHER_LANES threads a point: each follows as many of them.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define NEAREST_GROUP GATHER_GROUP
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/gathering/final_gather.glsl"

layout(local_size_x = GATHER_GROUP) in;
layout(constant_id = GATHER_LANES_ID) const uint GATHER_LANES = 8;
layout(push_constant, scalar) uniform Push { GatherPush push; };
layout(set = 0, binding = 9, scalar) readonly buffer PointState { uint point_state[POINT_STATE_WORDS]; };
layout(set = 0, binding = 10, scalar) readonly buffer Points { GatherPointRecord points[]; };
layout(set = 0, binding = 11, scalar) writeonly buffer GatheredLight { GatheredRecord gathered_light[]; };

GatherPoint gather_point(GatherPointRecord record) {
    const Hit hit = Hit(0.0, record.instance, record.triangle, record.u, record.v);
    GatherPoint point;
    point.surface = make_shading_point(hit, record.ray_direction);
    const Bsdf bsdf = make_bsdf(point.surface, record.outside_ior);
    point.rough = bsdf_rough_part(bsdf, mapping.glossy_threshold);
    point.wo = to_local(point.surface.shading, -record.ray_direction);
    point.lit_normal = bsdf_has_non_delta_transmission(bsdf) ? vec3(0.0) : point.surface.shading.normal;
    point.scatterings = record.scatterings;
    point.media = MediumStack(record.media);
    point.key = record.key;
    point.rays = record.rays;
    point.light_samples = record.light_samples;
    return point;
}

void main() {
    const uint place = flat_index() / GATHER_LANES, lane = flat_index() % GATHER_LANES;
    if (place >= min(point_state[POINTS_WORD], push.capacity)) return;
    Gathered gathered = Gathered(vec3(0.0), vec3(0.0), 0u, 0u, 0u);
    if (lane < points[place].rays) {
        const GatherPoint point = gather_point(points[place]);
        for (uint i = lane; i < point.rays; i += GATHER_LANES) gather_ray(point, i, gathered);
    }
    gathered_light[flat_index()] = GatheredRecord(gathered.direct, gathered.indirect, gathered.photons);
    count(COUNTER_BOUNCE_RAYS, gathered.rays);
    count(COUNTER_SHADOW_RAYS, gathered.shadow_rays);
}
