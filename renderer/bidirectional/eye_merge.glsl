// Merging of a vertex of the eye's path with vertices of light paths that lie where it is. CPU twin: merge() of
// eye_paths.cpp. Define LIGHT_VERTICES_BINDING, GRID_STARTS_BINDING and GRID_PLACES_BINDING (of set 0) before, and what
// join_vertex.glsl wants.
#ifndef PHOTOND_EYE_MERGE_GLSL
#define PHOTOND_EYE_MERGE_GLSL

#include "renderer/bidirectional/join_vertex.glsl"
#include "renderer/bidirectional/light_vertices.glsl"

void merge_with(LightVertexRecord light_vertex, uint vertex, JoinVertex at, vec3 scale, inout JoinedLight light) {
    const uint surfaces = surfaces_of(light_vertex);
    const uint scatterings = at.path.scatterings + surfaces;
    if (scatterings > eye.max_scatterings) return;
    const ShadingPoint point = at.surface.point;
    const float most_height_m = MERGE_MOST_HEIGHT * techniques.merge_radius_m;
    if (abs(dot(point.geometric_normal, light_vertex.position - point.position)) > most_height_m) return;
    const float side_cosine = dot(light_vertex.normal, point.geometric_normal);
    if ((side_cosine < 0.0 && !bsdf_has_non_delta_transmission(at.surface.bsdf)) || abs(side_cosine) < DISC_COSINE)
        return;
    // A vertex of a curved surface's next facet may have been lit from below this one's horizon.
    if ((dot(light_vertex.from, point.geometric_normal) > 0.0) != (side_cosine > 0.0)) return;
    const BsdfValue value = bsdf_evaluate(at.surface.bsdf, to_local(point.shading, at.surface.from),
                                          to_local(point.shading, light_vertex.from));
    if (is_black(value.f_cos)) return;
    const VertexSide eye_side =
        VertexSide(vertex == 0, light_pdf_back(at.surface, light_vertex.from), at.acceptance);
    const VertexSide light_side = VertexSide(surfaces == 1, value.pdf_sa, 0.0);
    const float weight = mis_merging(at.weights, eye_side, light_vertex.weights, light_side, techniques.numbers);
    const float share = 1.0 / max(abs(dot(light_vertex.from, light_vertex.normal)), DISC_LEAST_COSINE);
    const bool caustic = at.path.scatterings == 0 && surfaces > 1 &&
                         (light_vertex.surfaces & LIGHT_VERTEX_ALL_DELTA) != 0;
    add_joined(light, scatterings, caustic, JOIN_MERGE, weight * share * scale * value.f_cos * light_vertex.power_w);
}

void merge_vertex(uint vertex, JoinVertex at, inout JoinedLight light) {
    if (at.acceptance == 0.0 || light_vertex_count() == 0) return;
    const float radius_sq_m2 = sqr(techniques.merge_radius_m);
    const vec3 scale = at.path.throughput / (PI * radius_sq_m2);
    GridSearch search = grid_search(techniques.vertex_grid, at.surface.point.position, techniques.merge_radius_m);
    uint index;
    uvec4 place;
    float distance_sq;
    while (grid_next(techniques.vertex_grid, search, radius_sq_m2, index, place, distance_sq))
        if (distance_sq < radius_sq_m2) merge_with(light_vertices[place.w], vertex, at, scale, light);
}

#endif
