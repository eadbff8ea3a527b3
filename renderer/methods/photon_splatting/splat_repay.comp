#version 460
// What the clamp of connections takes, given back to the visible points, a thread a point.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define IMAGE_BINDING 0
#define COUNTERS_BINDING 1
#define EYE_BINDING 2
#define SAMPLER_BINDING 3
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/many_lights/clamp_repayment.glsl"
#include "renderer/methods/photon_splatting/splat_gain.glsl"

layout(local_size_x = SPLAT_GROUP) in;
layout(push_constant, scalar) uniform Push { SplatPointPush push; };
layout(set = 0, binding = 4, scalar) readonly buffer Constants { SplatConstants constants; };
layout(set = 0, binding = 5, scalar) readonly buffer Points { SplatPoint points[]; };
layout(set = 0, binding = 6, scalar) readonly buffer GeneralPoints { GBufferGeneral general_points[]; };
layout(set = 0, binding = 7, scalar) buffer Sums { SplatSum sums[]; };

void main() {
    const uint index = push.first_point + flat_index();
    if (index < push.end_point) {
        const SplatPoint point = points[index];
        const ClampedPoint clamped =
            ClampedPoint(point.position, point.pixel, point.normal, point.kind & ~POINT_GENERAL, point.geometric_normal,
                         is_general(point), clamp_sq_m2(point.splat_radius_m));
        GBufferGeneral of_general;
        if (clamped.general) of_general = general_points[index];
        const RepaymentSettings settings =
            RepaymentSettings(true, false, constants.glossy_threshold, constants.photon_threshold);
        sums[index].sum += clamp_repayment(clamped, of_general, settings).clamped;
        count(COUNTER_BOUNCE_RAYS, repayment_bounce_rays);
        count(COUNTER_SHADOW_RAYS, repayment_shadow_rays);
    }
}
