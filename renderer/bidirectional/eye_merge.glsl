// Merging of a vertex of the eye's path with vertices of light paths that lie where it is. CPU twin: merge() of
// eye_paths.cpp. Define LIGHT_VERTICES_BINDING, GRID_STARTS_BINDING and GRID_PLACES_BINDING (of set 0) before, and what
// join_vertex.glsl wants.
#ifndef PHOTOND_EYE_MERGE_GLSL
#define PHOTOND_EYE_MERGE_GLSL

#include "renderer/bidirectional/join_vertex.glsl"
#include "renderer/bidirectional/light_vertices.glsl"
#include "renderer/photons/disc_coverage.glsl"

/// Of a caustic's light: CPU's LightVertex::caustic().
bool is_caustic(LightVertexRecord light_vertex) {
    return surfaces_of(light_vertex) > 1 && (light_vertex.surfaces & LIGHT_VERTEX_ALL_DELTA) != 0;
}

/// Whether it lies on the disc about the eye's, not regarding the distance.
bool is_merged(LightVertexRecord light_vertex, JoinVertex at, float radius_m) {
    if (at.path.scatterings + surfaces_of(light_vertex) > eye.max_scatterings) return false;
    const ShadingPoint point = at.surface.point;
    const float most_height_m = MERGE_MOST_HEIGHT * radius_m;
    if (abs(dot(point.geometric_normal, light_vertex.position - point.position)) > most_height_m) return false;
    const float side_cosine = dot(light_vertex.normal, point.geometric_normal);
    if ((side_cosine < 0.0 && !bsdf_has_non_delta_transmission(at.surface.bsdf)) || abs(side_cosine) < DISC_COSINE)
        return false;
    // A vertex of a curved surface's next facet may have been lit from below this one's horizon.
    return (dot(light_vertex.from, point.geometric_normal) > 0.0) == (side_cosine > 0.0);
}

void merge_with(LightVertexRecord light_vertex, uint vertex, JoinVertex at, float acceptance, vec3 scale,
                inout JoinedLight light) {
    const uint surfaces = surfaces_of(light_vertex);
    const uint scatterings = at.path.scatterings + surfaces;
    const ShadingPoint point = at.surface.point;
    const BsdfValue value = bsdf_evaluate(at.surface.bsdf, to_local(point.shading, at.surface.from),
                                          to_local(point.shading, light_vertex.from));
    if (is_black(value.f_cos)) return;
    const VertexSide eye_side =
        VertexSide(vertex == 0, light_pdf_back(at.surface, light_vertex.from), acceptance);
    const VertexSide light_side = VertexSide(surfaces == 1, value.pdf_sa, 0.0);
    const float weight = mis_merging(at.weights, eye_side, light_vertex.weights, light_side, techniques.numbers);
    const float share = 1.0 / max(abs(dot(light_vertex.from, light_vertex.normal)), DISC_LEAST_COSINE);
    const bool caustic = at.path.scatterings == 0 && is_caustic(light_vertex);
    add_joined(light, scatterings, caustic, JOIN_MERGE, weight * share * scale * value.f_cos * light_vertex.power_w);
}

/// With caustics' vertices, or the others; with all, where they have the same disc. `cut`: it may be.
void merge_within(bool caustics, bool cut, uint vertex, uint key, JoinVertex at, inout JoinedLight light) {
    const float share = caustics ? techniques.numbers.caustic_radius : 1.0;
    const bool all = techniques.numbers.caustic_radius == 1.0;
    const float radius_m = share * techniques.merge_radius_m, radius_sq_m2 = sqr(radius_m);
    const ShadingPoint point = at.surface.point;
    DiscProbe probe;
    // The disc's mass is asked for with the first vertex on it.
    bool has_mass = !cut;
    DiscMass mass = DiscMass(1.0, false);
    JoinedLight merged = light;
    // Some vertices are asked for whether they are hidden, and all of them, from the start, once one is, or a place was.
    bool asks = false;
    for (bool again = true; again;) {
        again = false;
        merged = light;
        uint vertices = 0, next_asked = 0;  // number of the vertex
        uint index;
        uvec4 place;
        float distance_sq;
        GridSearch search = grid_search(techniques.vertex_grid, point.position, radius_m);
        while (grid_next(techniques.vertex_grid, search, radius_sq_m2, index, place, distance_sq)) {
            if (!(distance_sq < radius_sq_m2)) continue;
            const LightVertexRecord light_vertex = light_vertices[place.w];
            if (!all && is_caustic(light_vertex) != caustics) continue;
            if (!is_merged(light_vertex, at, radius_m)) continue;
            if (!has_mass) {
                probe = probe_disc(CoverageDisc(point.position, point.geometric_normal, radius_m,
                                                MERGE_MOST_HEIGHT * radius_m));
                RandomStream random = make_random_stream(techniques.join_salt, RANDOM_DOMAIN_MERGING_DISCS,
                                                         vertex, uint64_t(key));
                mass = disc_mass(KernelRecord(KERNEL_CONSTANT, 1.0 / PI, 0.0), probe,
                                 random_stream_next_bits(random), vertex == 0 ? DISC_FINE_BATCH : DISC_COARSE_BATCH);
                asks = mass.hides;
                has_mass = true;
            }
            if (cut && (asks || vertices == next_asked)) {
                next_asked = 2 * vertices + 1;
                if (!disc_sees(probe, light_vertex.position)) {
                    if (asks) continue;
                    asks = again = true;
                    break;
                }
            }
            ++vertices;
            merge_with(light_vertex, vertex, at, sqr(share) * at.acceptance,
                       mass.inverse / (PI * radius_sq_m2) * at.path.throughput, merged);
        }
    }
    light = merged;
}

void merge_vertex(uint vertex, uint key, JoinVertex at, inout JoinedLight light) {
    if (at.acceptance == 0.0 || light_vertex_count() == 0) return;
    const bool cut = has_edges(at.surface.point.position, techniques.edge_radius_m);
    const uint discs = techniques.numbers.caustic_radius < 1.0 ? 2 : 1;
    for (uint disc = 0; disc < discs; ++disc) merge_within(disc == 1, cut, vertex, key, at, light);
}

#endif
