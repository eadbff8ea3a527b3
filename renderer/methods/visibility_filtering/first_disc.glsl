// By the proxies' discs: a voxel is met where a ray meets one of its discs. Define VISIBILITY (the VisibilityConstants)
// and LISTS before, and include hash_grid.glsl with the grid's bindings, and met_voxel.glsl.
#ifndef PHOTOND_FIRST_DISC_GLSL
#define PHOTOND_FIRST_DISC_GLSL

#include "renderer/methods/visibility_filtering/proxy_voxel.glsl"

/// Whether the ray meets a disc of the voxel `met.slot`, farther off than its own surface's are. What is said of it is of
/// the nearest, for lists that count.
bool meets_disc(vec3 origin, vec3 direction, inout MetVoxel met) {
    const uint end = grid_starts[VISIBILITY.grid.first_start + met.slot + 1];
    const float radius_m = VISIBILITY.disc_radius_m;
    float nearest_m = INFINITY;
    for (uint i = grid_starts[VISIBILITY.grid.first_start + met.slot]; i < end; ++i) {
        const uvec4 place = grid_places[i];
        if (place.w == NO_PROXY) continue;
        const vec3 offset = uintBitsToFloat(place.xyz) - origin;
        const float along = dot(offset, direction);
        // The ball about the disc first: most are missed by it.
        if (!(along > radius_m) || !(dot(offset, offset) - sqr(along) < sqr(radius_m))) continue;
        const vec3 n = proxy_normal(place.w);
        const float t = dot(n, offset) / dot(n, direction);
        const vec3 from_middle = t * direction - offset;
        if (!(t > radius_m && t < nearest_m) || !(dot(from_middle, from_middle) < sqr(radius_m))) continue;
        met.place = uintBitsToFloat(place.xyz);
        if (LISTS != LISTS_COUNTS) return true;
        nearest_m = t;
        met.where_lit = proxy_is_lit(place.w) && dot(n, direction) < 0.0;
    }
    return nearest_m < INFINITY;
}

/// From voxel to voxel along the ray. [Amanatides and Woo 1987] A Fast Voxel Traversal Algorithm for Ray Tracing.
bool first_disc(vec3 origin, vec3 normal, vec3 direction, out MetVoxel met) {
    met = MetVoxel(0u, false, NO_PLACE);
    const HashGridConstants grid = VISIBILITY.grid;
    const vec3 start = (origin - grid.origin) * grid.cells_per_m, step = direction * grid.cells_per_m;
    const ivec3 forward = ivec3(sign(step));
    const bvec3 moves = greaterThan(abs(step), vec3(1e-20));
    const vec3 a_cell = mix(vec3(INFINITY), abs(1.0 / step), moves);
    ivec3 cell = clamp(ivec3(floor(start)), ivec3(0), grid.cells - 1);
    const vec3 next_wall = vec3(cell) + max(vec3(forward), vec3(0.0));
    vec3 t = mix(vec3(INFINITY), (next_wall - start) / step, moves);
    while (true) {
        met.slot = uint((cell.z * grid.cells.y + cell.y) * grid.cells.x + cell.x);
        if (meets_disc(origin, direction, met)) return true;
        const int axis = t.x <= t.y && t.x <= t.z ? 0 : t.y <= t.z ? 1 : 2;
        if (!(t[axis] < INFINITY)) return false;
        cell[axis] += forward[axis];
        t[axis] += a_cell[axis];
        if (cell[axis] < 0 || cell[axis] >= grid.cells[axis]) return false;
    }
    return false;
}

#endif
