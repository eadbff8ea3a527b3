// The vertices that the light paths of a pass left (LightVertex of light_paths.h). Define LIGHT_VERTICES_BINDING (of set
// 0) before.
#ifndef PHOTOND_LIGHT_VERTICES_GLSL
#define PHOTOND_LIGHT_VERTICES_GLSL

#include "renderer/bidirectional/bidirectional_shared.h"
#include "renderer/transport/bsdf_material.glsl"
#include "renderer/transport/vertex_scattering.glsl"

layout(set = 0, binding = LIGHT_VERTICES_BINDING, scalar) readonly buffer LightVertices {
    LightVertexRecord light_vertices[];
};

uint surfaces_of(LightVertexRecord vertex) { return vertex.surfaces & ~LIGHT_VERTEX_ALL_DELTA; }

/// As the path met it.
SurfaceVertex light_surface(LightVertexRecord vertex) {
    const ShadingPoint point =
        make_shading_point(Hit(0.0, vertex.instance, vertex.triangle, vertex.u, vertex.v), -vertex.from);
    return SurfaceVertex(point, make_bsdf(point, vertex.outside_ior), vertex.from);
}

#endif
