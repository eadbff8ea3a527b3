#version 460
// What a photon brings to the point of a pixel that it is drawn over: add_photon() of photon_scatter.comp.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/gbuffer/receiver.glsl"
#include "renderer/gbuffer/split_buffer.glsl"
#include "renderer/methods/image_space_photon_mapping/photon_scatter_shared.h"

layout(push_constant, scalar) uniform Push { PhotonRasterPush push; };
layout(location = 0) flat in uint photon;
layout(location = 0) out vec4 light_and_photons;
layout(set = 0, binding = 0, scalar) readonly buffer Constants { PhotonScatterConstants constants; };
layout(set = 0, binding = 1, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 4, std430) readonly buffer GridPlaces { uvec4 grid_places[]; };
layout(set = 0, binding = 5, std430) readonly buffer MapPowers { uvec4 map_powers[]; };
#define FOOTPRINTS constants
#define FOOTPRINT_RADIUS_M constants.radius_of_map_m[push.map]
#include "renderer/methods/image_space_photon_mapping/photon_light.glsl"

void main() {
    const SplitRecord split = constants.split;
    const uvec2 at = uvec2(gl_FragCoord.xy) * split.side + (split.side > 1u ? split.side / 2u : 0u);
    if (at.x >= split.width || at.y >= split.height) discard;
    const GBufferPoint point = points[split_point_of(split, at.x, at.y)];
    if (!is_lit(point) || is_general(point)) discard;
    const HashGridConstants map = constants.maps[push.map];
    Receiver receiver;  // of points that are not Lambert
    FootprintHit hit;
    if (!reaches_point(grid_places[map.first_point + photon], point, receiver, false, hit)) discard;
    light_and_photons = vec4(photon_light(map_powers[map.first_point + photon], point, receiver, hit), 1.0);
}
