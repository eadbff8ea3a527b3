// GLSL twin of photons/hash_grid.h: the cells of a grid, and the points about a place. Define GRID_STARTS_BINDING and
// GRID_PLACES_BINDING (of set 0) before, where points are looked for.
#ifndef PHOTOND_HASH_GRID_GLSL
#define PHOTOND_HASH_GRID_GLSL

#include "renderer/core/geometry.glsl"
#include "renderer/core/rng.glsl"
#include "renderer/photons/hash_grid_shared.h"

ivec3 grid_cell_of(HashGridConstants grid, vec3 p) {
    precise const vec3 t = (p - grid.origin) * grid.cells_per_m;
    const vec3 last = vec3(grid.cells - 1);
    // Written so that NaN is cell 0.
    return ivec3(t.x > 0.0 ? min(t.x, last.x) : 0.0, t.y > 0.0 ? min(t.y, last.y) : 0.0,
                 t.z > 0.0 ? min(t.z, last.z) : 0.0);
}

/// Where the row of cells (y, z) begins in the table; hashed: to be taken modulo its size.
uint grid_row(HashGridConstants grid, int y, int z) {
    if (grid.hashed != 0) return hash32(uint(y) ^ hash32(uint(z)));
    return uint(z * grid.cells.y + y) * uint(grid.cells.x);
}

uint grid_slot_of(HashGridConstants grid, vec3 p) {
    const ivec3 cell = grid_cell_of(grid, p);
    const uint slot = grid_row(grid, cell.y, cell.z) + uint(cell.x);
    return grid.hashed != 0 ? slot & (grid.slots - 1u) : slot;
}

#ifdef GRID_STARTS_BINDING

layout(set = 0, binding = GRID_STARTS_BINDING, scalar) readonly buffer GridStarts { uint grid_starts[]; };
layout(set = 0, binding = GRID_PLACES_BINDING, std430) readonly buffer GridPlaces {
    uvec4 grid_places[];  // position, and a word of the point's own
};

bool is_empty(HashGridConstants grid) { return grid_starts[grid.first_start + grid.slots] == 0; }

/// A walk through the rows of cells that a sphere touches, point after point.
struct GridSearch {
    vec3 centre;
    int low_x, low_y, high_y, high_z;
    uint columns;
    int y, z;      // the row under way
    uint wrapped;  // of its columns, those that are left at the table's beginning
    uint at, end;  // its points
};

GridSearch grid_search(HashGridConstants grid, vec3 centre, float radius_m) {
    // All roundings on the way to a cell are monotonic: a radius that is more than the distance's own rounding too
    // large misses no cell.
    const vec3 reach = vec3(radius_m * 1.000001);
    const ivec3 low = grid_cell_of(grid, centre - reach), high = grid_cell_of(grid, centre + reach);
    return GridSearch(centre, low.x, low.y, high.y, high.z, uint(high.x - low.x + 1), low.y - 1, low.z, 0u, 0u, 0u);
}

/// The squared distance as searches round it.
float grid_distance_sq(vec3 p, vec3 q) {
    precise const vec3 d = q - p;
    precise const float distance_sq = d.x * d.x + d.y * d.y + d.z * d.z;
    return distance_sq;
}

/// To the next run of points, which may be empty: the next row's, or the rest of one that ran over the table's end.
/// False: there is none.
bool grid_next_run(HashGridConstants grid, inout GridSearch search) {
    uint slot = 0, columns = search.wrapped;
    search.wrapped = 0;
    if (columns == 0) {
        const bool up = search.y >= search.high_y;
        search.y = up ? search.low_y : search.y + 1;
        search.z += up ? 1 : 0;
        if (search.z > search.high_z) return false;
        slot = grid_row(grid, search.y, search.z) + uint(search.low_x);
        columns = search.columns;
        if (grid.hashed != 0) {
            slot &= grid.slots - 1u;
            columns = min(columns, grid.slots - slot);
            search.wrapped = search.columns - columns;
        }
    }
    search.at = grid_starts[grid.first_start + slot];
    search.end = grid_starts[grid.first_start + slot + columns];
    return true;
}

/// The next point at squared distances up to `bound_sq`, which is not beyond the search's radius, each point once;
/// `index` counts from the grid's first. False: there is none. One loop over runs and points: threads that run together
/// need not wait for each other's runs to end.
bool grid_next(HashGridConstants grid, inout GridSearch search, float bound_sq, out uint index, out uvec4 point,
               out float distance_sq) {
    while (true) {
        if (search.at >= search.end) {
            if (!grid_next_run(grid, search)) return false;
            continue;
        }
        index = search.at++;
        point = grid_places[grid.first_point + index];
        const vec3 position = uintBitsToFloat(point.xyz);
        distance_sq = grid_distance_sq(search.centre, position);
        // Rows that meet in the table hold each other's points.
        if (distance_sq <= bound_sq &&
            (grid.hashed == 0 || grid_cell_of(grid, position).yz == ivec2(search.y, search.z)))
            return true;
    }
}

#endif

#endif
