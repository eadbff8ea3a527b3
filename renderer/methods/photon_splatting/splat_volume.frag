#version 460
// What a beam brings to the visible point of a pixel: add_splat() of splat_light.comp.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/eye/eye_shared.h"
#define DEPTH_MAPS_BINDING 5
#include "renderer/methods/photon_splatting/splat_depth_maps.glsl"
#include "renderer/methods/photon_splatting/splat_gain.glsl"

layout(constant_id = SPLAT_NORMALISED_ID) const bool SPLAT_NORMALISED = false;
layout(constant_id = SPLAT_VISIBILITY_ID) const bool SPLAT_VISIBILITY = true;

layout(location = 0) flat in uint splat_index;
layout(location = 0) out vec4 light_and_splats;
layout(location = 1) out vec2 weight_and_contributions;
layout(set = 0, binding = 0, scalar) readonly buffer Eye { EyeConstants eye; };
layout(set = 0, binding = 1, scalar) readonly buffer Splats { Splat splats[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Constants { SplatConstants constants; };
layout(set = 0, binding = 3, scalar) readonly buffer Heads { uint first_of_pixel[]; };
layout(set = 0, binding = 4, scalar) readonly buffer Points { SplatPoint points[]; };

void main() {
    const uvec2 at = uvec2(gl_FragCoord.xy);
    const uint index = first_of_pixel[at.y * eye.width + at.x];
    if (index == NO_POINT) discard;
    const SplatPoint point = points[index];
    const Splat splat = splats[splat_index];
    float gain;
    if (splat.kind >> SPLAT_SCATTERINGS_SHIFT > point.kind || !beam_gain(splat, point, constants.kernel, gain)) discard;
    light_and_splats = vec4(0.0);
    weight_and_contributions = vec2(0.0, 1.0);
    const vec3 d = point.position - splat.origin;
    if (SPLAT_VISIBILITY && !reaches(splat_index, constants.shadow_resolution, splat, d)) return;
    light_and_splats = vec4(gain * splat.intensity, 1.0);
    // The filter's weight without the receiver's cosine.
    if (SPLAT_NORMALISED) weight_and_contributions.x = splat.weight * gain / -dot(point.normal, splat.axis);
}
