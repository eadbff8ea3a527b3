// Cones through the tree's light. Asks for what cone_cells.glsl asks for. [Crassin et al. 2011, section 5]
#ifndef PHOTOND_CONE_MARCH_GLSL
#define PHOTOND_CONE_MARCH_GLSL

#include "renderer/core/rng.glsl"
#include "renderer/methods/voxel_cone_tracing/cone_cells.glsl"

layout(constant_id = EVERY_CELL_ID) const bool EVERY_CELL = false;

/// Where a cone leaves a surface: cells that the surface's plane crosses are its own, and do not count.
struct ConeStart {
    vec3 place;   // in voxels
    vec3 normal;  // on the side that the cone leaves to; 0: of no surface
};

struct Cone {
    vec3 direction;  // unit
    float aperture;  // its width over its length
    float step;      // over its width
};

vec3 to_voxels(vec3 position) { return (position - svo_constants.grid.low) * svo_constants.voxels_per_m; }

/// What a cell of 2^mip voxels sends against the cone, and how much of a step through it stops: of each axis as much as
/// its side shows of itself.
vec4 seen_of_cell(int mip, ivec3 place, ConeStart start, Cone cone) {
    const float size = ldexp(1.0, mip), kOffPlane = 0.01;  // of cells whose side lies in the plane
    const vec3 middle = (vec3(place) + 0.5) * size;
    if (start.normal != vec3(0.0) &&
        dot(middle - start.place, start.normal) < 0.5 * size * dot(abs(start.normal), vec3(1.0)) + kOffPlane)
        return vec4(0.0);
    const uint cell = cone_cell_at(mip, place);
    if (cell == NO_CONE_CELL) return vec4(0.0);
    const vec3 shown = abs(cone.direction) / max_component(abs(cone.direction));
    vec4 seen = vec4(0.0);
    for (int axis = 0; axis < 3; ++axis) {
        const uint side = 2u * uint(axis) + (cone.direction[axis] > 0.0 ? 1u : 0u);  // that looks against the cone
        seen += shown[axis] *
                vec4(unpack_shared_exponent(cone_cells[cell].light[side]), cone_opacity(cone_cells[cell], axis));
    }
    if (!(seen.w > 0.0)) return vec4(0.0);
    const float stopped = seen.w < 1.0 ? 1.0 - pow(1.0 - seen.w, min(cone.step, 1.0)) : 1.0;
    return vec4(seen.xyz / seen.w * stopped, stopped);
}

/// Between the middles of the eight cells about a place (in voxels); or one of them, by chance in proportion to its share.
vec4 seen_of_mip(int mip, vec3 place, ConeStart start, Cone cone, inout uint random) {
    const vec3 at = ldexp(place, ivec3(-mip)) - 0.5, first = floor(at), between = at - first;
    if (!EVERY_CELL) {
        random = hash32(random);
        const vec3 u = (vec3(random & 0x3ffu, random >> 10u & 0x3ffu, random >> 20u & 0x3ffu) + 0.5) / 1024.0;
        return seen_of_cell(mip, ivec3(first) + ivec3(lessThan(u, between)), start, cone);
    }
    vec4 seen = vec4(0.0);
    for (int i = 0; i < 8; ++i) {
        const ivec3 corner = ivec3(i & 1, i >> 1 & 1, i >> 2);
        const vec3 part = mix(1.0 - between, between, vec3(corner));
        const float weight = part.x * part.y * part.z;
        if (weight > 0.0) seen += weight * seen_of_cell(mip, ivec3(first) + corner, start, cone);
    }
    return seen;
}

/// Between the two sizes of cells about the cone's width, or one of the two by chance.
vec4 seen_at(float mip, int last_mip, vec3 place, ConeStart start, Cone cone, inout uint random) {
    const int finer = int(mip);
    const float rest = finer < last_mip ? mip - float(finer) : 0.0;
    if (!EVERY_CELL) {
        random = hash32(random);
        return seen_of_mip(to_unit_float(random) < rest ? finer + 1 : finer, place, start, cone, random);
    }
    const vec4 seen = seen_of_mip(finer, place, start, cone, random);
    return rest > 0.0 ? mix(seen, seen_of_mip(finer + 1, place, start, cone, random), rest) : seen;
}

/// Radiance that comes against a cone, whose first look is `first` voxels ahead. `random`: of the cone.
vec3 cone_radiance(ConeStart start, Cone cone, float first, uint random) {
    const float resolution = float(svo_constants.grid.resolution);
    const int last_mip = int(cone_tree.levels) + 1, most_steps = 1024;
    const float kLeastLeft = 0.01;  // of the light that gets through: farther the cone does not look
    vec3 light = vec3(0.0);
    float left = 1.0, t = first;
    for (int i = 0; i < most_steps && left > kLeastLeft; ++i) {
        const float width = max(1.0, cone.aperture * t);
        const vec3 place = start.place + t * cone.direction;
        if (any(lessThan(place, vec3(-width))) || any(greaterThan(place, vec3(resolution + width)))) break;
        const vec4 seen = seen_at(min(log2(width), float(last_mip)), last_mip, place, start, cone, random);
        light += left * seen.xyz;
        left *= 1.0 - seen.w;
        t += cone.step * width;
    }
    return light;
}

#endif
