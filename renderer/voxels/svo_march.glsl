// GLSL twin of voxels/svo_march.h. Define SVO_CONSTANTS_BINDING, SVO_NODES_BINDING and SVO_BRICKS_BINDING (of set 0)
// before, and SVO_SURFACES_BINDING where the tree has surfaces and they are wanted: SparseVoxelOctreeGpu's buffers.
#ifndef PHOTOND_SVO_MARCH_GLSL
#define PHOTOND_SVO_MARCH_GLSL

#extension GL_EXT_scalar_block_layout : require

#include "renderer/core/geometry.glsl"
#include "renderer/voxels/svo_shared.h"

layout(set = 0, binding = SVO_CONSTANTS_BINDING, scalar) readonly buffer SvoConstantsBuffer { SvoConstants svo_constants; };
layout(set = 0, binding = SVO_NODES_BINDING, scalar) readonly buffer SvoNodes { SvoNode svo_nodes[]; };
layout(set = 0, binding = SVO_BRICKS_BINDING, scalar) readonly buffer SvoBricks { uvec2 svo_bricks[]; };
#ifdef SVO_SURFACES_BINDING
layout(set = 0, binding = SVO_SURFACES_BINDING, scalar) readonly buffer SvoSurfaces { uint svo_surfaces[]; };
#endif

/// A brick's bit of a voxel.
uint svo_bit(ivec3 voxel) { return uint((voxel.x & 3) | ((voxel.y & 3) << 2) | ((voxel.z & 3) << 4)); }
bool svo_has_bit(uvec2 mask, uint bit) { return (((bit < 32u ? mask.x : mask.y) >> (bit & 31u)) & 1u) != 0u; }

/// The leaf that holds a voxel: a brick's place, or SVO_NO_DATA for an empty box of `size` voxels.
uint svo_find_leaf(ivec3 voxel, out int size) {
    uint tile = 0u;
    size = int(svo_constants.grid.resolution);
    for (uint level = 1u; level <= SVO_MOST_LEVELS; ++level) {
        size >>= 1;
        const uint child = ((voxel.x & size) != 0 ? 1u : 0u) | ((voxel.y & size) != 0 ? 2u : 0u) |
                           ((voxel.z & size) != 0 ? 4u : 0u);
        const uint node = 8u * tile + child, info = svo_nodes[node].info;
        if ((info & SVO_FLAGGED) == 0u) return SVO_NO_DATA;
        if (level == svo_constants.levels) return svo_nodes[node].data;
        tile = info & SVO_TILE_MASK;
    }
    return SVO_NO_DATA;
}

ivec3 svo_voxel_at(vec3 p, ivec3 low, ivec3 high) {
    return clamp(ivec3(floor(clamp(p, vec3(-1.0), vec3(VOXEL_MOST_RESOLUTION)))), low, high);
}

struct SvoSetVoxel {
    float t;
    ivec3 voxel;
    uint brick;
};

/// The first set voxel that origin + t direction [voxels] lies in, for t in [t_begin, t_end).
bool svo_walk(vec3 origin, vec3 direction, float t_begin, float t_end, out SvoSetVoxel hit) {
    hit = SvoSetVoxel(0.0, ivec3(0), SVO_NO_DATA);
    if (!is_finite(origin) || !is_finite(direction)) return false;
    const int resolution = int(svo_constants.grid.resolution);
    const float kLeast = 1e-20;
    const vec3 least = vec3(copysign(kLeast, direction.x), copysign(kLeast, direction.y), copysign(kLeast, direction.z));
    const bvec3 tiny = lessThan(abs(direction), vec3(kLeast));
    if (all(tiny)) return false;
    const vec3 inverse = 1.0 / mix(direction, least, tiny);
    const bvec3 forward = greaterThan(inverse, vec3(0.0));
    const vec3 to_low = -origin * inverse, to_high = (vec3(resolution) - origin) * inverse;
    const vec3 enter = min(to_low, to_high), leave = max(to_low, to_high);
    float t = max(max(t_begin, enter.x), max(enter.y, enter.z));
    t_end = min(min(t_end, leave.x), min(leave.y, leave.z));
    if (!(t < t_end)) return false;

    ivec3 voxel = svo_voxel_at(origin + t * direction, ivec3(0), ivec3(resolution - 1));
    for (int turns = 0; turns < 3 * resolution; ++turns) {
        int size;
        const uint brick = svo_find_leaf(voxel, size);
        const uvec2 mask = brick == SVO_NO_DATA ? uvec2(0u) : svo_bricks[brick];
        const ivec3 box_low = voxel & ~(size - 1), box_last = box_low + (size - 1);
        if (brick != SVO_NO_DATA) size = 1;
        // An empty box is left in one step, a brick voxel by voxel.
        for (int steps = 0; steps < 3 * BRICK_SIDE; ++steps) {
            if (svo_has_bit(mask, svo_bit(voxel))) {
                hit = SvoSetVoxel(t, voxel, brick);
                return true;
            }
            const ivec3 low = voxel & ~(size - 1), last = low + (size - 1);
            const vec3 leave_at = (vec3(mix(low, last + 1, forward)) - origin) * inverse;
            const float t_leave = min(leave_at.x, min(leave_at.y, leave_at.z));
            const bvec3 axis = bvec3(leave_at.x == t_leave, leave_at.x != t_leave && leave_at.y == t_leave,
                                     leave_at.x != t_leave && leave_at.y != t_leave);
            t = max(t, t_leave);
            if (!(t < t_end)) return false;
            if (size > 1) {
                const ivec3 now = svo_voxel_at(origin + t * direction, low, last);
                voxel = mix(min(voxel, now), max(voxel, now), forward);
            }
            voxel = mix(voxel, mix(low - 1, last + 1, forward), axis);
            if (any(lessThan(voxel, ivec3(0))) || any(greaterThanEqual(voxel, ivec3(resolution)))) return false;
            if (any(lessThan(voxel, box_low)) || any(greaterThan(voxel, box_last))) break;
        }
    }
    return false;
}

vec3 svo_to_voxels(vec3 p) { return (p - svo_constants.grid.low) * svo_constants.voxels_per_m; }

/// Voxels that are entered farther than `reach` from a do not count.
bool svo_occluded_between(vec3 a, vec3 b, float pull_in, float reach) {
    const float distance = length(b - a);
    if (!(distance > 2.0 * pull_in)) return false;
    SvoSetVoxel hit;
    return svo_walk(a, (b - a) / distance, pull_in, min(distance - pull_in, reach), hit);
}

/// A point on a surface lifted off the voxels that the surface's plane is in: towards `normal`, unit.
vec3 svo_lift(vec3 position, vec3 normal) {
    const vec3 n = abs(normal);
    return position + SVO_NORMAL_OFFSET * svo_constants.grid.cell_m * (n.x + n.y + n.z) * normal;
}

/// Whether the open segment between two points on surfaces meets a set voxel; false where what is left of it once its
/// ends are pulled in is nothing, and for positions that are no numbers.
bool svo_occluded(vec3 a, vec3 b) {
    return svo_occluded_between(svo_to_voxels(a), svo_to_voxels(b), SVO_BLIND_PULL_IN, INFINITY);
}

/// The same with unit normals of the sides that the segment leaves to. Voxels that it enters farther than `reach_m` from
/// a do not count.
bool svo_occluded(vec3 a, vec3 normal_a, vec3 b, vec3 normal_b, float reach_m) {
    const vec3 from = svo_to_voxels(svo_lift(a, normal_a)), to = svo_to_voxels(svo_lift(b, normal_b));
    if (!(dot(to - from, b - a) > 0.0)) return false;  // nearer to each other than they were lifted
    return svo_occluded_between(from, to, SVO_PULL_IN, reach_m * svo_constants.voxels_per_m);
}
bool svo_occluded(vec3 a, vec3 normal_a, vec3 b, vec3 normal_b) {
    return svo_occluded(a, normal_a, b, normal_b, INFINITY);
}

#ifdef SVO_SURFACES_BINDING
/// The number of the triangle in a set voxel.
uint svo_surface(uint brick, ivec3 voxel) {
    const uvec2 mask = svo_bricks[brick];
    const uint bit = svo_bit(voxel), below = (1u << (bit & 31u)) - 1u;
    const uint before = bit < 32u ? uint(bitCount(mask.x & below)) : uint(bitCount(mask.x) + bitCount(mask.y & below));
    return svo_surfaces[svo_constants.surface_base + svo_surfaces[brick] + before];
}
#endif

#ifdef SVO_SURFACES_BINDING
/// The number of the triangle in the voxel that holds a point; SVO_NO_DATA where that is not set, or outside of the grid.
uint svo_surface_at(vec3 position) {
    const vec3 at = svo_to_voxels(position);
    if (!(all(greaterThanEqual(at, vec3(0.0))) && all(lessThan(at, vec3(svo_constants.grid.resolution)))))
        return SVO_NO_DATA;
    const ivec3 voxel = ivec3(at);
    int size;
    const uint brick = svo_find_leaf(voxel, size);
    if (brick == SVO_NO_DATA || !svo_has_bit(svo_bricks[brick], svo_bit(voxel))) return SVO_NO_DATA;
    return svo_surface(brick, voxel);
}
#endif

/// The first set voxel that the ray meets in [0, t_max); nothing is moved. `t`: where it enters it, 0 in the one it
/// starts in; `surface`: the number of its triangle, where the tree has them. False: none, or a direction of 0.
bool svo_first_voxel(Ray ray, out float t, out uvec3 voxel, out uint surface) {
    t = INFINITY, voxel = uvec3(0u), surface = SVO_NO_DATA;
    SvoSetVoxel set;
    if (!(ray.t_max > 0.0) || !svo_walk(svo_to_voxels(ray.origin), ray.direction, 0.0,
                                        ray.t_max * svo_constants.voxels_per_m, set))
        return false;
    t = set.t * svo_constants.grid.cell_m;
    voxel = uvec3(set.voxel);
#ifdef SVO_SURFACES_BINDING
    surface = svo_surface(set.brick, set.voxel);
#endif
    return true;
}

#endif
