#version 460
// What connections leave out at the points of a G-buffer, a thread a point: what the clamp takes, for the layer `clamped`
// and the points' sums where it is given back, and what narrow lobes send.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define IMAGE_BINDING 0
#define COUNTERS_BINDING 1
#define EYE_BINDING 2
#define SAMPLER_BINDING 3
#define GRID_STARTS_BINDING 8
#define GRID_PLACES_BINDING 9
#define MAP_POWERS_BINDING 10
#define CAUSTIC_ESTIMATE_BINDING 11
#define NEAREST_GROUP SPLIT_GROUP
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/many_lights/vpl_lighting_shared.h"
#include "renderer/many_lights/clamp_repayment.glsl"
#include "renderer/gbuffer/gbuffer_walk_shared.h"

layout(constant_id = CLAMP_IS_ASKED_ID) const bool CLAMP_IS_ASKED = true;
layout(constant_id = CLAMP_IS_REPAID_ID) const bool CLAMP_IS_REPAID = true;
layout(constant_id = NARROW_IS_ASKED_ID) const bool NARROW_IS_ASKED = true;

layout(local_size_x = SPLIT_GROUP) in;
layout(push_constant, scalar) uniform Push { PointPush push; };
layout(set = 0, binding = 4, scalar) readonly buffer Constants { VplLightingConstants constants; };
layout(set = 0, binding = 5, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 6, scalar) readonly buffer GeneralPoints { GBufferGeneral general_points[]; };
layout(set = 0, binding = 7, scalar) buffer Sums { vec3 sums[]; };

void main() {
    const uint index = push.first_point + flat_index();
    if (index < push.end_point) {
        const GBufferPoint point = points[index];
        if ((point.kind & GBUFFER_SCATTERINGS) != 0u) {
            const ClampedPoint clamped =
                ClampedPoint(point.position, point.pixel, point.normal, point.kind & GBUFFER_SCATTERINGS,
                             point.geometric_normal, (point.kind & GBUFFER_GENERAL) != 0u, constants.clamp_sq_m2);
            GBufferGeneral of_general;
            if (!ONLY_LAMBERT && clamped.general) of_general = general_points[index];
            const LeftOut left_out = clamp_repayment(
                clamped, of_general, RepaymentSettings(CLAMP_IS_ASKED, NARROW_IS_ASKED, constants.glossy_threshold,
                                                       constants.connect_threshold));
            sums[index] += (CLAMP_IS_REPAID ? left_out.clamped : vec3(0.0)) + left_out.narrow;
            if (layer_kept(LAYER_CLAMPED)) store_rgb(LAYER_CLAMPED, point.pixel, point.weight * left_out.clamped);
        }
        count(COUNTER_BOUNCE_RAYS, repayment_bounce_rays);
        count(COUNTER_SHADOW_RAYS, repayment_shadow_rays);
    }
}
