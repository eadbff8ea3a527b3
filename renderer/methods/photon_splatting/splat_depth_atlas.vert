#version 460
// A triangle of the scene as a splat's frustum sees it, in the splat's tile: an instance a splat. Nothing is drawn beyond the
// tile, before the near plane or behind the far one.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/bvh_shared.h"
#include "renderer/backends/gpu/scene_bindings.h"
#include "renderer/core/geometry.glsl"
#include "renderer/methods/photon_splatting/splat_depth_shared.h"
#include "renderer/methods/photon_splatting/splat_shared.h"

layout(push_constant, scalar) uniform Push { SplatDepthPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Splats { Splat splats[]; };
// In world space: there are no instances in the tree.
layout(set = SCENE_SET, binding = BVH_TRIANGLES_BINDING, scalar) readonly buffer BvhTriangles { BvhTriangle bvh_triangles[]; };
out float gl_ClipDistance[4];

void main() {
    const Splat splat = splats[push.first_splat + gl_InstanceIndex];
    const uint triangle = gl_VertexIndex / 3;
    if ((splat.kind & SPLAT_KIND_MASK) != SPLAT_BEAM || triangle >= bvh_triangles.length()) {
        gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
        for (int i = 0; i < 4; ++i) gl_ClipDistance[i] = -1.0;
        return;
    }
    const Frame axes = make_frame(splat.axis);
    const float depth = max(splat.far_m - splat.near_m, 1e-6 * splat.radius);
    const vec3 d = bvh_triangles[triangle].corners[gl_VertexIndex % 3] - (splat.origin + splat.near_m * splat.axis);
    const vec2 across = vec2(dot(d, axes.tangent), dot(d, axes.bitangent)) / splat.radius;  // -1 to 1
    gl_ClipDistance[0] = 1.0 + across.x;
    gl_ClipDistance[1] = 1.0 - across.x;
    gl_ClipDistance[2] = 1.0 + across.y;
    gl_ClipDistance[3] = 1.0 - across.y;
    const vec2 tile = vec2(gl_InstanceIndex % push.columns, gl_InstanceIndex / push.columns);
    gl_Position = vec4((2.0 * tile + across + 1.0) / vec2(push.columns, push.rows) - 1.0, dot(d, splat.axis) / depth, 1.0);
}
