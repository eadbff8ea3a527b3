// Cells that light propagates in, and what they send. Define PROPAGATION_CASCADES_BINDING (of set 0) before.
#ifndef PHOTOND_PROPAGATION_GLSL
#define PHOTOND_PROPAGATION_GLSL

#extension GL_EXT_scalar_block_layout : require

#include "renderer/core/geometry.glsl"
#include "renderer/methods/light_propagation_volumes/propagation_shared.h"

layout(set = 0, binding = PROPAGATION_CASCADES_BINDING, scalar) readonly buffer Cascades { PropagationCascades cascades; };

PropagationGrid cascade_grid(uint cascade) { return cascades.grids[cascade]; }

bool is_in_grid(PropagationGrid grid, ivec3 cell) {
    return all(greaterThanEqual(cell, ivec3(0))) && all(lessThan(cell, ivec3(grid.cells)));
}
uint cell_index(PropagationGrid grid, ivec3 cell) {
    return uint(cell.x) + grid.cells.x * (uint(cell.y) + grid.cells.y * uint(cell.z));
}
ivec3 cell_at(PropagationGrid grid, uint index) {
    return ivec3(index % grid.cells.x, index / grid.cells.x % grid.cells.y, index / (grid.cells.x * grid.cells.y));
}
/// Of a cell's low faces, and of those of the cell past the last one.
uint face_index(PropagationGrid grid, ivec3 cell) {
    const uvec3 rows = grid.cells + 1u;
    return uint(cell.x) + rows.x * (uint(cell.y) + rows.y * uint(cell.z));
}
vec3 cell_middle(PropagationGrid grid, ivec3 cell) { return grid.low + grid.cell_m * (vec3(cell) + 0.5); }
/// In cells from the grid's least corner.
vec3 grid_place(PropagationGrid grid, vec3 position) { return (position - grid.low) / grid.cell_m; }

/// The eight cells about a place (in cells from the grid's corner), by their first one, and where it lies between them.
ivec3 cells_about(PropagationGrid grid, vec3 place, out vec3 between) {
    const vec3 at = clamp(place - 0.5, vec3(0.0), vec3(grid.cells) - 1.0);
    const ivec3 first = min(ivec3(at), ivec3(grid.cells) - 2);
    between = at - vec3(first);
    return first;
}
ivec3 cell_about(int i) { return ivec3(i & 1, i >> 1 & 1, i >> 2); }
float weight_about(int i, vec3 between) {
    const vec3 part = mix(1.0 - between, between, vec3(cell_about(i)));
    return part.x * part.y * part.z;
}

const CellLight NO_LIGHT = CellLight(vec4(0.0), vec4(0.0), vec4(0.0));

void add_light(inout CellLight sum, CellLight one, float share) {
    sum.red += share * one.red;
    sum.green += share * one.green;
    sum.blue += share * one.blue;
}

/// Flux [W] that leaves along a unit normal with a cosine: 1 / 4 + cos / 2 of the lobe cos / pi is of order 1 or less.
CellLight cosine_lobe(vec3 flux_w, vec3 normal) {
    const vec4 lobe = INV_PI * vec4(0.25, 0.5 * normal);
    return CellLight(flux_w.x * lobe, flux_w.y * lobe, flux_w.z * lobe);
}

/// Of the flux itself, a factor on what is left of an intensity where its negative part is cut off: the mean of
/// max(0, a + b cos) over all directions is (a + b)^2 / (4 b) where b > a.
float uncut_share(vec4 channel) {
    const float a = channel.x, b = length(channel.yzw);
    return b > a ? 4.0 * a * b / sqr(a + b) : 1.0;
}
vec3 uncut_shares(CellLight light) {
    return vec3(uncut_share(light.red), uncut_share(light.green), uncut_share(light.blue));
}
vec3 intensity(CellLight light, vec3 direction) {
    return max(vec3(light.red.x + dot(light.red.yzw, direction), light.green.x + dot(light.green.yzw, direction),
                    light.blue.x + dot(light.blue.yzw, direction)),
               vec3(0.0));
}

#endif
