// The light of the volumes at points of the image. Define PROPAGATION_CASCADES_BINDING, INJECTED_BINDING, VOLUME_BINDING and
// OPEN_FACES_BINDING (of set 0) before.
#ifndef PHOTOND_VOLUME_POINTS_GLSL
#define PHOTOND_VOLUME_POINTS_GLSL

#include "renderer/backends/gpu/bvh.glsl"
#include "renderer/gbuffer/gbuffer_point.glsl"
#include "renderer/methods/light_propagation_volumes/propagation.glsl"

layout(set = 0, binding = INJECTED_BINDING, scalar) readonly buffer Injected { CellLight injected[]; };
layout(set = 0, binding = VOLUME_BINDING, scalar) readonly buffer Volume { CellLight volume[]; };

layout(set = 0, binding = OPEN_FACES_BINDING, scalar) readonly buffer OpenFaces { uint open_faces[]; };

layout(constant_id = ASKS_CELLS_ID) const bool ASKS_CELLS = true;

/// What passes through cells, over the area that a cell shows to it, 3/2 of a side in the mean: radiance.
struct VolumeLight {
    CellLight started;    // in the cells about the point
    CellLight travelled;  // came from others
};

/// Where a point's light is asked for, in cells: half a cell off its surface.
vec3 asked_place(PropagationGrid grid, GBufferPoint point) {
    const vec3 off = point.normal == vec3(0.0) ? vec3(0.0) : 0.5 * point.geometric_normal;
    return grid_place(grid, point.position) + off;
}

/// Whether something stands between any two neighbours of the eight cells that are among those of the mask.
bool are_apart(uint cascade, PropagationGrid grid, ivec3 first, uint mask) {
    for (int i = 0; i < 8; ++i)
        for (int axis = 0; axis < 3; ++axis) {
            const uint pair = 1u << i | 1u << (i | 1 << axis);
            if ((i >> axis & 1) != 0 || (mask & pair) != pair) continue;
            const uint word = open_faces[cascade * cascades.faces + face_index(grid, first + cell_about(i | 1 << axis))];
            if ((word >> (FACE_BITS * uint(axis)) & FACE_OPEN) != FACE_OPEN) return true;
        }
    return false;
}

/// Of those cells the ones whose middles the point sees; all of them where it sees none.
uint cells_seen(PropagationGrid grid, GBufferPoint point, ivec3 first, uint mask) {
    uint seen = 0u;
    for (int i = 0; i < 8; ++i) {
        if ((mask >> i & 1u) == 0u) continue;
        const vec3 middle = cell_middle(grid, first + cell_about(i));
        const bool behind = dot(middle - point.position, point.geometric_normal) < 0.0;
        const vec3 origin = offset_ray_origin(point.position, behind ? -point.geometric_normal : point.geometric_normal);
        if (!occluded(Ray(origin, middle - origin, 1.0))) seen |= 1u << i;
    }
    return seen != 0u ? seen : mask;
}

/// Between the middles of the eight cells about the place, without those behind the point's surface and, where something
/// stands between the others, those that it does not see.
void add_interpolated(inout VolumeLight sum, uint cascade, GBufferPoint point, float share) {
    const PropagationGrid grid = cascade_grid(cascade);
    vec3 between;
    const ivec3 first = cells_about(grid, asked_place(grid, point), between);
    uint mask = 0u;
    for (int i = 0; i < 8; ++i) {
        const vec3 to_middle = cell_middle(grid, first + cell_about(i)) - point.position;
        if (point.normal == vec3(0.0) || dot(to_middle, point.geometric_normal) > 0.0) mask |= 1u << i;
    }
    if (ASKS_CELLS && are_apart(cascade, grid, first, mask)) mask = cells_seen(grid, point, first, mask);
    float weights[8], total = 0.0;
    for (int i = 0; i < 8; ++i) {
        weights[i] = (mask >> i & 1u) != 0u ? weight_about(i, between) : 0.0;
        total += weights[i];
    }
    if (!(total > 0.0)) return;
    share /= 1.5 * total;
    const float per_m = 1.0 / grid.cell_m;
    for (int i = 0; i < 8; ++i) {
        if (!(weights[i] > 0.0)) continue;
        const uint cell = cascade * cascades.cells + cell_index(grid, first + cell_about(i));
        add_light(sum.started, injected[cell], share * weights[i] * per_m * per_m);
        add_light(sum.travelled, volume[cell], share * weights[i] * per_m * per_m);
    }
}

/// Of the finest cascade that has the point; over the last cells before its end it becomes the coarser one's.
VolumeLight volume_light(GBufferPoint point) {
    const float kLastCells = 2.0;
    VolumeLight light = VolumeLight(NO_LIGHT, NO_LIGHT);
    float left = 1.0;
    for (uint i = cascades.count; i-- > 0u && left > 0.0;) {
        const PropagationGrid grid = cascade_grid(i);
        const vec3 place = asked_place(grid, point), inside = min(place, vec3(grid.cells) - place) - 1.0;
        const float depth = min(inside.x, min(inside.y, inside.z));
        const float share = i == 0u ? left : left * clamp(depth / kLastCells, 0.0, 1.0);
        if (share > 0.0) add_interpolated(light, i, point, share);
        left -= share;
    }
    return light;
}

/// E = pi a - 2 pi / 3 b.n of radiance a + b.w that arrives along w; what is less than nothing is cut off.
vec3 irradiance(CellLight light, vec3 normal) {
    return PI * max(vec3(light.red.x - dot(light.red.yzw, normal) * (2.0 / 3),
                         light.green.x - dot(light.green.yzw, normal) * (2.0 / 3),
                         light.blue.x - dot(light.blue.yzw, normal) * (2.0 / 3)),
                    vec3(0.0));
}
vec3 irradiance(VolumeLight light, vec3 normal) {
    return irradiance(light.started, normal) + irradiance(light.travelled, normal);
}
vec3 radiance_from(VolumeLight light, vec3 direction) {
    return intensity(light.started, -direction) + intensity(light.travelled, -direction);
}

#endif
