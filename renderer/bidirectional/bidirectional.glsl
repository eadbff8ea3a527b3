// What light and eye paths share on the device: how often each technique is tried, and where vertices merge
// (PassTechniques of bidirectional_scene.h). Define BIDIRECTIONAL_BINDING (of set 0) before, and that of the tables
// over the light's vertices: GRID_STARTS_BINDING with GRID_PLACES_BINDING where vertices are looked for (hash_grid.glsl),
// else LIGHT_TABLES_BINDING.
#ifndef PHOTOND_BIDIRECTIONAL_GLSL
#define PHOTOND_BIDIRECTIONAL_GLSL

#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

#include "renderer/bidirectional/bidirectional_shared.h"
#include "renderer/bidirectional/mis_weights.glsl"
#include "renderer/transport/vertex_scattering.glsl"

layout(set = 0, binding = BIDIRECTIONAL_BINDING, scalar) readonly buffer Bidirectional {
    BidirectionalConstants techniques;
};

#ifdef GRID_STARTS_BINDING
#include "renderer/photons/hash_grid.glsl"
#else
layout(set = 0, binding = LIGHT_TABLES_BINDING, scalar) readonly buffer LightTables { uint grid_starts[]; };
#endif

/// Vertices that the light paths of the pass left.
uint light_vertex_count() { return min(grid_starts[0], techniques.capacity); }

#define COVERAGE techniques.edges
#define EDGE_WORD(index) grid_starts[index]
#include "renderer/photons/edge_tree.glsl"

/// PassTechniques::merge_disc_at() that place, its acceptance_m2().
float merge_acceptance(vec3 position, bool caustic) {
    if (!(techniques.merge_radius_m > 0.0)) return 0.0;
    const float disc_m2 = PI * sqr((caustic ? techniques.numbers.caustic_radius : 1.0) * techniques.merge_radius_m);
    return has_edges(position, techniques.edge_radius_m) ? MERGE_EDGE_SHARE * disc_m2 : disc_m2;
}

#endif
