#version 460
// What the clamp of connections takes from the points of a G-buffer, a thread a point: to the layer `clamped`, and to the
// points' sums where it is given back.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define IMAGE_BINDING 0
#define COUNTERS_BINDING 1
#define EYE_BINDING 2
#define SAMPLER_BINDING 3
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/methods/clamp_repayment.glsl"
#include "renderer/methods/device_gbuffer_shared.h"
#include "renderer/methods/vpl_lighting_shared.h"

layout(constant_id = CLAMP_IS_REPAID_ID) const bool CLAMP_IS_REPAID = true;

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
            const ClampedPoint clamped = ClampedPoint(
                point.position, point.pixel, point.normal, point.kind & GBUFFER_SCATTERINGS, point.geometric_normal,
                (point.kind & GBUFFER_GENERAL) != 0u, constants.clamp_sq_m2);
            GBufferGeneral of_general;
            if (!ONLY_LAMBERT && clamped.general) of_general = general_points[index];
            const vec3 taken =
                clamp_repayment(clamped, of_general, constants.glossy_threshold, constants.connect_threshold);
            if (CLAMP_IS_REPAID) sums[index] += taken;
            if (layer_kept(PLANE_CLAMPED)) store_rgb(PLANE_CLAMPED, point.pixel, point.weight * taken);
        }
        count(COUNTER_BOUNCE_RAYS, repayment_bounce_rays);
        count(COUNTER_SHADOW_RAYS, repayment_shadow_rays);
    }
}
