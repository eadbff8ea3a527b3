#version 460
// What light from each texel brings to some of the points that the eye sees, a thread a texel: CPU twin CameraImportance.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/many_lights/camera_importance.glsl"
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
    const float light = unshadowed(point, position, normal, push.clamp_sq_m2);
    if (!(light > 0.0)) return 0.0;
    if (IMPORTANCE_HAS_TREE && svo_occluded(point.position, importance_side(point, position), position, normal))
        return 0.0;
    return light;
}

void main() {
    const uint texel = push.first_texel + flat_index();
    if (texel >= push.end_texel || !(importance[texel] > 0.0)) return;
    const RandomStream random = importance_stream(push.seed, push.pass);
    float sum = 0.0;
    for (uint i = 0; i < CAMERA_IMPORTANCE_POINTS; ++i)
        sum += brought(points[importance_point(random, i, push.points)], texels[texel].position,
                       texels[texel].normal);
    importance[texel] *= sum;
}
