#version 460
// The faces of a beam's frustum that look away from the camera, an instance a splat: all that the camera sees through a
// convex volume, once. The frustum is a little larger than the beam, so that it is seen in every pixel whose sample lies in
// the beam, wherever in the pixel that is.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/core/geometry.glsl"
#include "renderer/eye/eye_shared.h"
#include "renderer/methods/photon_splatting/splat_shared.h"
#include "renderer/splats/splat_film.glsl"

layout(push_constant, scalar) uniform Push { SplatClusterPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Eye { EyeConstants eye; };
layout(set = 0, binding = 1, scalar) readonly buffer Splats { Splat splats[]; };
layout(location = 0) flat out uint splat_index;

// Two triangles of a face in its own plane.
const vec2 CORNERS[6] = {vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, -1), vec2(1, 1), vec2(-1, 1)};

void main() {
    splat_index = push.first_splat + gl_InstanceIndex;
    gl_Position = OFF_FILM;
    const Splat splat = splats[splat_index];
    if ((splat.kind & SPLAT_KIND_MASK) != SPLAT_BEAM) return;
    const Frame frame = make_frame(splat.axis);
    const vec3 axes[3] = {frame.tangent, frame.bitangent, frame.normal};
    const vec3 centre = splat.origin + 0.5 * (splat.near_m + splat.far_m) * splat.axis - eye.camera.position;
    vec3 half_m = vec3(splat.radius, splat.radius, 0.5 * (splat.far_m - splat.near_m));
    const float pixels = sample_reach(eye.smooth_filter != 0 ? FILTER_RADIUS : 0.5);
    half_m += pixels_m(eye.camera, pixels, dot(centre, eye.camera.forward) + length(half_m)) + 1e-3 * splat.radius;

    const uint face = gl_VertexIndex / 6, along = face / 2;
    const float side = face % 2 == 0 ? -1.0 : 1.0;
    const vec3 middle = centre + side * half_m[along] * axes[along];
    if (!(dot(middle, side * axes[along]) > 0.0)) return;  // it looks towards the camera
    const uint u = (along + 1) % 3, v = (along + 2) % 3;
    const vec2 corner = CORNERS[gl_VertexIndex % 6];
    const vec3 d = middle + corner.x * half_m[u] * axes[u] + corner.y * half_m[v] * axes[v];
    gl_Position = film_position(eye.camera, vec2(eye.width, eye.height), d);
}
