#version 460
// Photons as shapes about what they light, an instance a photon: a quad of two triangles along the surface; an icosahedron
// flattened along its normal; or, for both forms together, a box. Of those with an inside the faces are drawn that look away
// from the camera: all that is seen through a convex volume, once. Shapes are a little larger than the footprints, so that
// they are seen in every pixel whose sample they light, wherever in the pixel that is.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/methods/image_space_photon_mapping/photon_scatter_shared.h"
#include "renderer/photons/photon.glsl"
#include "renderer/splats/splat_film.glsl"
#include "renderer/transport/sampling.glsl"

layout(constant_id = FOOTPRINT_ID) const uint FOOTPRINT = FOOTPRINT_QUAD;

layout(push_constant, scalar) uniform Push { PhotonRasterPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Constants { PhotonScatterConstants constants; };
layout(set = 0, binding = 3, scalar) readonly buffer GridStarts { uint grid_starts[]; };
layout(set = 0, binding = 4, std430) readonly buffer GridPlaces { uvec4 grid_places[]; };
layout(location = 0) flat out uint photon;

// Two triangles of a face in its own plane.
const vec2 CORNERS[6] = {vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, -1), vec2(1, 1), vec2(-1, 1)};

// The icosahedron whose sides touch the unit ball; B is A times the golden ratio.
const float A = 0.6615845, B = 1.0704663;
const vec3 POINTS[12] = {vec3(-A, B, 0), vec3(A, B, 0), vec3(-A, -B, 0), vec3(A, -B, 0), vec3(0, -A, B), vec3(0, A, B),
                         vec3(0, -A, -B), vec3(0, A, -B), vec3(B, 0, -A), vec3(B, 0, A), vec3(-B, 0, -A), vec3(-B, 0, A)};
const uint SIDES[60] = {0, 11, 5,  0, 5, 1,  0, 1, 7,  0, 7, 10, 0, 10, 11, 1, 5, 9, 5, 11, 4,  11, 10, 2,  10, 7, 6, 7, 1, 8,
                        3, 9,  4,  3, 4, 2,  3, 2, 6,  3, 6, 8,  3, 8,  9,  4, 9, 5, 2, 4,  11, 6,  2,  10, 8,  6, 7, 9, 8, 1};

CameraConstants camera() { return constants.camera; }

/// Of the image that is drawn: the film, or the sub-samples of it.
vec4 image_position(vec3 d) {
    const SplitRecord split = constants.split;
    vec4 position = film_position(camera(), vec2(split.width, split.height), d);
    if (split.side == 1u) return position;
    const vec2 film = 0.5 * (position.xy / position.w + 1.0) * vec2(split.width, split.height);
    const vec2 image = (film - float(split.side / 2u) - 0.5) / float(split.side) + 0.5;
    position.xy = (2.0 * image / vec2(split.tile_width, split.tile_height) - 1.0) * position.w;
    return position;
}

/// The quad lies so that two of its sides are seen in full length, and its sides are moved out by the margin in the image.
vec4 quad_corner(vec3 centre, vec3 normal, float radius_m, float margin_pixels) {
    const vec3 view = camera().orthographic != 0 ? camera().forward : centre;
    const vec3 level = cross(normal, view), level_unit = level * inversesqrt(max(dot(level, level), 1e-30));
    const vec3 across = dot(level, level) > 1e-8 * dot(view, view) ? level_unit : make_frame(normal).tangent;
    const vec3 along = cross(normal, across);
    const vec2 corner = CORNERS[gl_VertexIndex];
    const vec3 d = centre + radius_m * (corner.x * across + corner.y * along);
    const vec2 size = vec2(constants.split.width, constants.split.height);
    const vec4 position = film_position(camera(), size, d), middle = film_position(camera(), size, centre);
    const vec4 beside = film_position(camera(), size, centre + radius_m * across);
    if (!(min(min(position.w, middle.w), beside.w) > 0.0)) return image_position(d);
    const vec2 level_pixels = (beside.xy / beside.w - middle.xy / middle.w) * size;
    const vec2 to_corner = (position.xy / position.w - middle.xy / middle.w) * size;
    const vec2 u = level_pixels * inversesqrt(max(dot(level_pixels, level_pixels), 1e-30)), v = vec2(-u.y, u.x);
    const vec2 out_of_middle = margin_pixels * (sign(corner.x) * u + (dot(to_corner, v) >= 0.0 ? 1.0 : -1.0) * v);
    return image_position(d + position.w * (out_of_middle.x * camera().pixel_x + out_of_middle.y * camera().pixel_y));
}

/// Of a side: its corner and where it looks, before it is flattened.
void solid_corner(out vec3 corner, out vec3 outwards) {
    if (FOOTPRINT == FOOTPRINT_VOLUME) {
        const uint first = gl_VertexIndex / 3 * 3;
        corner = POINTS[SIDES[gl_VertexIndex]];
        outwards = POINTS[SIDES[first]] + POINTS[SIDES[first + 1]] + POINTS[SIDES[first + 2]];
        return;
    }
    const uint face = gl_VertexIndex / 6, along = face / 2;
    const float side = face % 2 == 0 ? -1.0 : 1.0;
    const vec2 in_face = CORNERS[gl_VertexIndex % 6];
    corner = outwards = vec3(0.0);
    corner[along] = outwards[along] = side;
    corner[(along + 1) % 3] = in_face.x;
    corner[(along + 2) % 3] = in_face.y;
}

void main() {
    const HashGridConstants map = constants.maps[push.map];
    photon = push.first_photon + gl_InstanceIndex;
    gl_Position = OFF_FILM;
    if (photon >= min(grid_starts[map.first_start + map.slots], map.capacity)) return;
    const uvec4 place = grid_places[map.first_point + photon];
    const vec3 centre = uintBitsToFloat(place.xyz) - camera().position, normal = photon_normal(place.w);
    const float radius_m = constants.radius_of_map_m[push.map], pixels = sample_reach(constants.filter_reach);
    if (FOOTPRINT == FOOTPRINT_QUAD) {
        gl_Position = quad_corner(centre, normal, radius_m, 1.2 * pixels);  // perspective bends the sides
        return;
    }
    vec3 half_m = radius_m * vec3(1.0, 1.0, FOOTPRINT == FOOTPRINT_VOLUME
                                                ? constants.volume_height
                                                : max(constants.volume_height, QUAD_HEIGHT));
    half_m += pixels_m(camera(), pixels, dot(centre, camera().forward) + radius_m) + 1e-3 * radius_m;
    const Frame frame = make_frame(normal);
    vec3 corner, outwards;
    solid_corner(corner, outwards);
    const vec3 d = centre + to_world(frame, half_m * corner), normal_of_side = to_world(frame, outwards / half_m);
    const bool looks_away = camera().orthographic != 0 ? dot(normal_of_side, camera().forward) > 0.0
                                                       : dot(normal_of_side, d) > 0.0;
    if (looks_away) gl_Position = image_position(d);
}
