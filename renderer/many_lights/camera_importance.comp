#version 460
// What light from each texel brings to some of the points that the eye sees, a thread a texel: CPU twin CameraImportance.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/core/rng.glsl"
#include "renderer/gbuffer/gbuffer_shared.h"
#include "renderer/many_lights/vpl.glsl"
#include "renderer/many_lights/camera_importance_shared.h"
#include "renderer/photons/reflected_photon_shared.h"
#define SVO_CONSTANTS_BINDING 3
#define SVO_NODES_BINDING 4
#define SVO_BRICKS_BINDING 5
#include "renderer/voxels/svo_march.glsl"

layout(constant_id = IMPORTANCE_HAS_TREE_ID) const bool IMPORTANCE_HAS_TREE = true;

layout(local_size_x = CAMERA_IMPORTANCE_GROUP) in;
layout(push_constant, scalar) uniform Push { CameraImportancePush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Texels { ReflectedPhotonRecord texels[]; };
layout(set = 0, binding = 2, scalar) buffer Importance { float importance[]; };

/// What flux leaving there brings to one point, over that flux.
float brought(GBufferPoint point, vec3 position, vec3 normal) {
    const vec3 d = point.position - position;
    const float d_sq = dot(d, d);
    if (point.kind == 0u || !(d_sq > 0.0)) return 0.0;
    const vec3 w = d / sqrt(d_sq);
    const float cos_o = dot(normal, w), cos_x = point.normal == vec3(0.0) ? 1.0 : -dot(point.normal, w);
    if (!(cos_o > 0.0 && cos_x > 0.0)) return 0.0;
    const vec3 side = dot(point.geometric_normal, w) < 0.0 ? point.geometric_normal : -point.geometric_normal;
    if (IMPORTANCE_HAS_TREE && svo_occluded(point.position, side, position, normal)) return 0.0;
    const float weight = max_component(point.weight) * ((point.kind & GBUFFER_GENERAL) != 0u ? INV_PI : 1.0);
    return weight * cos_o * cos_x * clamped_falloff(d_sq, push.clamp_sq_m2);
}

void main() {
    const uint texel = push.first_texel + flat_index();
    if (texel >= push.end_texel || !(importance[texel] > 0.0)) return;
    RandomStream random =
        make_random_stream(push.seed, RANDOM_DOMAIN_SPLATS, push.pass, uint64_t(CAMERA_IMPORTANCE_STREAM));
    float sum = 0.0;
    for (uint i = 0; i < CAMERA_IMPORTANCE_POINTS; ++i) {
        const uint point = random_stream_next_bits(random) % push.points;
        sum += brought(points[point], texels[texel].position, texels[texel].normal);
    }
    importance[texel] *= sum;
}
