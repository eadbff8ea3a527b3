// Connections of a vertex of the eye's path with vertices of light paths. CPU twin: connect() of eye_paths.cpp. Define
// LIGHT_VERTICES_BINDING and LIGHT_ORDER_BINDING (of set 0) before, and what join_vertex.glsl wants.
#ifndef PHOTOND_EYE_CONNECT_GLSL
#define PHOTOND_EYE_CONNECT_GLSL

#include "renderer/bidirectional/join_vertex.glsl"
#include "renderer/bidirectional/light_vertices.glsl"

layout(set = 0, binding = LIGHT_ORDER_BINDING, scalar) readonly buffer LightOrder { uint light_order[]; };

void connect_with(LightVertexRecord light_vertex, float inverse_pdf, uint vertex, JoinVertex at,
                  inout JoinedLight light, inout uint shadow_rays) {
    const uint surfaces = surfaces_of(light_vertex);
    const uint scatterings = at.path.scatterings + 1 + surfaces;
    if (scatterings > eye.max_scatterings || scatterings < surfaces) return;
    const vec3 offset = light_vertex.position - at.surface.point.position;
    const float distance_sq = dot(offset, offset);
    if (!(distance_sq > 0.0)) return;
    const float distance = sqrt(distance_sq);
    const vec3 towards = offset / distance;
    const EyeScattering of_eye = scatter_to_light(at.surface, towards);
    if (is_black(of_eye.f_cos)) return;
    const SurfaceVertex other = light_surface(light_vertex);
    const LightScattering back = scatter_to_eye(other, -towards);
    if (is_black(back.density)) return;
    const float cos_eye = abs(dot(at.surface.point.geometric_normal, towards));
    const float cos_light = abs(dot(other.point.geometric_normal, towards));
    const float per_area = 1.0 / distance_sq;
    const float weight =
        mis_connection(at.weights, VertexSide(vertex == 0, of_eye.light_pdf, at.acceptance),
                       of_eye.eye_pdf * cos_light * per_area, light_vertex.weights,
                       VertexSide(surfaces == 1, back.eye_pdf, light_vertex.acceptance),
                       back.light_pdf * cos_eye * per_area, techniques.numbers);
    MediumStack media = at.path.media;
    if (dot(at.surface.point.geometric_normal, towards) < 0.0 && bsdf_refraction_eta(at.surface.bsdf) > 0.0)
        medium_stack_cross(media, at.surface.point.material, at.surface.point.front_side);
    const vec3 radiance = weight * inverse_pdf * per_area * at.path.throughput * of_eye.f_cos * back.density *
                          light_vertex.power_w * transmittance(media, distance);
    if (is_black(radiance)) return;
    const vec3 start = ray_origin(at.surface.point, towards);
    ++shadow_rays;
    if (occluded(Ray(start, ray_origin(other.point, -towards) - start, 1.0))) return;
    add_joined(light, scatterings, false, JOIN_CONNECTION, radiance);
}

void connect_vertex(uint vertex, uint key, JoinVertex at, inout JoinedLight light, inout uint shadow_rays) {
    const uint cached = light_vertex_count();
    if (cached == 0) return;
    uint first = 0, end = techniques.connections_per_vertex;
    RandomStream random;
    float inverse_pdf = float(cached) / float(end);
    const bool own = techniques.own_path != 0;
    if (own) {
        // Any of them: paths whose numbers lie in step with the image's pixels are alike.
        random = make_random_stream(techniques.join_salt, RANDOM_DOMAIN_CONNECTIONS, ~0u, uint64_t(key));
        const uint path =
            uint(uint64_t(random_stream_next_bits(random)) * uint64_t(techniques.light_paths) >> 32);
        first = grid_starts[techniques.first_of_paths + path];
        end = grid_starts[techniques.first_of_paths + path + 1];
        inverse_pdf = float(techniques.light_paths);
    } else {
        random = make_random_stream(techniques.join_salt, RANDOM_DOMAIN_CONNECTIONS, vertex, uint64_t(key));
    }
    for (uint k = first; k < end; ++k) {
        uint i = k;
        // One of each of as many equal parts of the cache; the number's 24 bits are those of a float.
        if (!own)
            i = uint((uint64_t(k) << 24 | uint64_t(random_stream_next_bits(random) >> 8)) * uint64_t(cached) /
                     (uint64_t(end) << 24));
        connect_with(light_vertices[light_order[min(i, cached - 1)]], inverse_pdf, vertex, at, light, shadow_rays);
    }
}

#endif
