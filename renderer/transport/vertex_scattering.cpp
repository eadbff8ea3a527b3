#include "renderer/transport/vertex_scattering.h"

namespace photond {

namespace {

bool on_same_side(const SurfaceVertex& vertex, const vec3& direction) {
    return glm::dot(vertex.point.geometric_normal, direction) > 0;
}

}  // namespace

SurfaceVertex seen_from(const SurfaceVertex& vertex, const vec3& from) {
    SurfaceVertex seen = vertex;
    seen.from = from;
    ShadingPoint& point = seen.point;
    if (!on_same_side(vertex, from)) {
        point.geometric_normal = -point.geometric_normal;
        point.smooth_normal = -point.smooth_normal;
        point.position += 2 * point.clearance_m * point.geometric_normal;
        point.front_side = !point.front_side;
    }
    const vec3 normal = normal_seen(point.smooth_normal, point.geometric_normal, -from);
    point.shading = Frame(normal);
    const vec3 geometric = point.shading.to_local(point.geometric_normal);
    seen.bsdf = point.front_side == vertex.point.front_side ? vertex.bsdf.with_geometric_normal(geometric)
                                                            : vertex.bsdf.from_far_side(geometric);
    return seen;
}

float light_pdf_back(const SurfaceVertex& eye_vertex, const vec3& to) {
    if (on_same_side(eye_vertex, to) && !has_two_frames(eye_vertex.point)) {
        const Frame& frame = eye_vertex.point.shading;
        return eye_vertex.bsdf.pdf_sa(frame.to_local(to), frame.to_local(eye_vertex.from));
    }
    const SurfaceVertex lit = seen_from(eye_vertex, to);
    return scatter_pdf(lit.point, lit.bsdf, to, eye_vertex.from);
}

float eye_pdf_back(const SurfaceVertex& light_vertex, const vec3& to) {
    if (on_same_side(light_vertex, to) && !has_two_frames(light_vertex.point)) {
        const Frame& frame = light_vertex.point.shading;
        return light_vertex.bsdf.pdf_sa(frame.to_local(to), frame.to_local(light_vertex.from));
    }
    const SurfaceVertex seen = seen_from(light_vertex, to);
    return seen.bsdf.pdf_sa(seen.point.shading.to_local(to), seen.point.shading.to_local(light_vertex.from));
}

EyeScattering scatter_to_light(const SurfaceVertex& eye_vertex, const vec3& to) {
    const Frame& frame = eye_vertex.point.shading;
    const BsdfValue value = eye_vertex.bsdf.evaluate(frame.to_local(eye_vertex.from), frame.to_local(to));
    if (is_black(value.f_cos)) return {};
    return {value.f_cos, value.pdf_sa, light_pdf_back(eye_vertex, to)};
}

LightScattering scatter_to_eye(const SurfaceVertex& light_vertex, const vec3& to) {
    const ShadingPoint& point = light_vertex.point;
    LightScattering scattering;
    if (has_two_frames(point)) {
        scattering.density = scatter_density(point, light_vertex.bsdf, light_vertex.from, to);
        if (is_black(scattering.density)) return {};
        scattering.light_pdf = scatter_pdf(point, light_vertex.bsdf, light_vertex.from, to);
    } else {
        const BsdfValue value = light_vertex.bsdf.evaluate(point.shading.to_local(light_vertex.from),
                                                           point.shading.to_local(to), TransportMode::Importance);
        if (is_black(value.f_cos)) return {};
        scattering.density = value.f_cos;
        scattering.light_pdf = value.pdf_sa;
    }
    scattering.eye_pdf = eye_pdf_back(light_vertex, to);
    return scattering;
}

}  // namespace photond
