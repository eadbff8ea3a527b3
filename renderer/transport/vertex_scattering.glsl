// GLSL twin of transport/vertex_scattering.h and .cpp: scattering at a vertex between a path from the eye and one from a
// light.
#ifndef PHOTOND_VERTEX_SCATTERING_GLSL
#define PHOTOND_VERTEX_SCATTERING_GLSL

#include "renderer/transport/photon_scattering.glsl"

/// A surface and its lobes as a path met them.
struct SurfaceVertex {
    ShadingPoint point;
    Bsdf bsdf;
    vec3 from;  // back to where the path came from
};

/// At the end of a path from the eye, from where it goes on, or is joined, towards the light.
struct EyeScattering {
    vec3 f_cos;       // f |cos| [1/sr], the cosine against the shading normal
    float eye_pdf;    // [1/sr] of `to`, for the eye's path
    float light_pdf;  // [1/sr] of the way back, for a light path that comes from `to`
};

/// At the end of a light path, from where it goes on, or is joined, towards the eye.
struct LightScattering {
    vec3 density;     // share of the power sent to each solid angle [1/sr], as scatter_density()
    float light_pdf;  // [1/sr] of `to`, for the light path
    float eye_pdf;    // [1/sr] of the way back, for an eye path that comes from `to`
};

bool on_same_side(SurfaceVertex vertex, vec3 direction) { return dot(vertex.point.geometric_normal, direction) > 0.0; }

/// The same place as met from `from`, on whichever side of the surface that is.
SurfaceVertex seen_from(SurfaceVertex vertex, vec3 from) {
    SurfaceVertex seen = vertex;
    seen.from = from;
    const bool same_side = on_same_side(vertex, from);
    if (!same_side) {
        seen.point.geometric_normal = -seen.point.geometric_normal;
        seen.point.smooth_normal = -seen.point.smooth_normal;
        seen.point.position += 2.0 * seen.point.clearance_m * seen.point.geometric_normal;
        seen.point.front_side = !seen.point.front_side;
    }
    seen.point.shading = make_frame(normal_seen(seen.point.smooth_normal, seen.point.geometric_normal, -from));
    const vec3 geometric = to_local(seen.point.shading, seen.point.geometric_normal);
    if (same_side)
        seen.bsdf = bsdf_with_geometric_normal(vertex.bsdf, geometric);
    else
        seen.bsdf = bsdf_from_far_side(vertex.bsdf, geometric);
    return seen;
}

// The densities alone, where something else has drawn the direction.

/// The vertex as a path that comes from `to` would meet it: as it is, where that is the same.
SurfaceVertex met_by_other(SurfaceVertex vertex, vec3 to) {
    if (on_same_side(vertex, to) && !has_two_frames(vertex.point)) return vertex;
    return seen_from(vertex, to);
}

float light_pdf_back(SurfaceVertex eye_vertex, vec3 to) {
    const SurfaceVertex lit = met_by_other(eye_vertex, to);
    return scatter_pdf(lit.point, lit.bsdf, to, eye_vertex.from);
}

float eye_pdf_back(SurfaceVertex light_vertex, vec3 to) {
    const SurfaceVertex seen = met_by_other(light_vertex, to);
    const Frame frame = seen.point.shading;
    return bsdf_pdf_sa(seen.bsdf, to_local(frame, to), to_local(frame, light_vertex.from));
}

EyeScattering scatter_to_light(SurfaceVertex eye_vertex, vec3 to) {
    const Frame frame = eye_vertex.point.shading;
    const BsdfValue value = bsdf_evaluate(eye_vertex.bsdf, to_local(frame, eye_vertex.from), to_local(frame, to));
    if (is_black(value.f_cos)) return EyeScattering(vec3(0.0), 0.0, 0.0);
    return EyeScattering(value.f_cos, value.pdf_sa, light_pdf_back(eye_vertex, to));
}

LightScattering scatter_to_eye(SurfaceVertex light_vertex, vec3 to) {
    const ShadingPoint point = light_vertex.point;
    LightScattering scattering = LightScattering(vec3(0.0), 0.0, 0.0);
    const bool two_frames = has_two_frames(point);
    if (two_frames) {
        scattering.density = scatter_density(point, light_vertex.bsdf, light_vertex.from, to);
    } else {
        const BsdfValue value = bsdf_evaluate(light_vertex.bsdf, to_local(point.shading, light_vertex.from),
                                              to_local(point.shading, to), TRANSPORT_IMPORTANCE);
        scattering.density = value.f_cos;
        scattering.light_pdf = value.pdf_sa;
    }
    if (is_black(scattering.density)) return scattering;
    if (two_frames) scattering.light_pdf = scatter_pdf(point, light_vertex.bsdf, light_vertex.from, to);
    scattering.eye_pdf = eye_pdf_back(light_vertex, to);
    return scattering;
}

/// The normal that points on lights are drawn by at such a vertex: 0 where light from both sides counts.
vec3 lit_normal_of(SurfaceVertex vertex) {
    return bsdf_has_non_delta_transmission(vertex.bsdf) ? vec3(0.0) : vertex.point.smooth_normal;
}

#endif
