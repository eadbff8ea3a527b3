#pragma once
// From "this ray met that triangle" to what shading needs to know about the place.

#include "renderer/core/rgb.h"
#include "renderer/scene/intersector.h"
#include "renderer/scene/scene.h"
#include "renderer/transport/ray_start.h"

namespace photond {

/// A hit made ready for shading, seen from the side the ray came from. World space [m].
///
/// The geometric normal is turned to the ray's side; which side that is in the file's eyes says `front_side`. The
/// smooth normal is the interpolated one, or what the normal map makes of it, and the same for whoever looks. Where it
/// faces away from the eye, the shading frame is about the geometric normal instead (such places would be black
/// otherwise): eyes see one of two frames, and the geometric one near silhouettes only.
struct ShadingPoint {
    vec3 position{0};                // clearance_m off the triangle, on the ray's side
    vec3 geometric_normal{0, 0, 1};  // unit, on the ray's side
    vec3 smooth_normal{0, 0, 1};     // unit, on the geometric normal's side
    Frame shading{vec3(0, 0, 1)};    // about normal_seen(); its tangents are arbitrary, as all BSDFs are isotropic
    uint32_t instance = kNoHit;
    uint32_t triangle = 0;
    float u = 0;  // barycentrics, as in Hit
    float v = 0;
    uint32_t material = 0;
    float clearance_m = 0;   // surface_clearance()
    bool front_side = true;  // the ray came from the side the triangle's winding faces
};

/// The surface at a valid hit of a ray with that (unit) direction, normal map included.
ShadingPoint make_shading_point(const Scene& scene, const Hit& hit, const vec3& ray_direction);

/// The same for scenes without normal maps (Needs::normal_maps), where it equals make_shading_point() bit by bit.
inline ShadingPoint make_plain_shading_point(const Scene& scene, const Hit& hit, const vec3& ray_direction);

/// Where a ray that leaves the point towards `direction` (unit) starts, on the side it leaves to.
inline vec3 ray_origin(const ShadingPoint& point, const vec3& direction) {
    const vec3& n = point.geometric_normal;
    if (glm::dot(direction, n) > 0) return step_off(point.position, n);
    return step_off(point.position - 2 * point.clearance_m * n, -n);
}

/// `normal` (of any length) made unit and turned to the geometric normal's side; the geometric normal where it is
/// degenerate.
inline vec3 turned_normal(const vec3& normal, const vec3& geometric_normal) {
    const float length_sq = glm::dot(normal, normal);
    if (!(length_sq > 1e-30f)) return geometric_normal;
    const float side = glm::dot(normal, geometric_normal) < 0 ? -1.0f : 1.0f;
    return normal * (side / std::sqrt(length_sq));
}

/// The normal that an eye looking along `ray_direction` shades with, both normals being on its side of the surface.
inline vec3 normal_seen(const vec3& smooth_normal, const vec3& geometric_normal, const vec3& ray_direction) {
    return glm::dot(smooth_normal, ray_direction) < 0 ? smooth_normal : geometric_normal;
}

/// Unit normal of two edges. In double where the square of a tiny or needle-like triangle's area leaves float's range.
inline vec3 unit_cross(const vec3& a, const vec3& b) {
    const vec3 cross = glm::cross(a, b);
    const float length_sq = glm::dot(cross, cross);
    if (length_sq > 1e-30f && length_sq < kInfinity) return cross * (1.0f / std::sqrt(length_sq));
    return vec3(glm::normalize(glm::cross(dvec3(a), dvec3(b))));
}

inline ShadingPoint make_plain_shading_point(const Scene& scene, const Hit& hit, const vec3& ray_direction) {
    const Instance& instance = scene.instances[hit.instance];
    const Mesh& mesh = scene.meshes[instance.mesh];
    const uvec3 corner = mesh.triangles[hit.triangle];
    vec3 p[3] = {mesh.positions[corner.x], mesh.positions[corner.y], mesh.positions[corner.z]};
    if (!instance.identity)
        for (vec3& q : p) q = instance.to_world * vec4(q, 1.0f);
    const float w = 1.0f - hit.u - hit.v;

    ShadingPoint point;
    point.instance = hit.instance;
    point.triangle = hit.triangle;
    point.u = hit.u;
    point.v = hit.v;
    point.material = mesh.material;
    point.clearance_m = surface_clearance(p[0], p[1], p[2]);
    vec3 ng = unit_cross(p[1] - p[0], p[2] - p[0]);
    if (instance.flips_orientation) ng = -ng;
    point.front_side = glm::dot(ng, ray_direction) < 0;
    point.geometric_normal = point.front_side ? ng : -ng;
    // Interpolated rather than taken along the ray: its error is that of the corners, not that of the distance.
    point.position = w * p[0] + hit.u * p[1] + hit.v * p[2] + point.clearance_m * point.geometric_normal;
    if (mesh.normals.empty()) {
        point.smooth_normal = point.geometric_normal;
        point.shading = Frame(point.geometric_normal);
    } else {
        vec3 n = w * mesh.normals[corner.x] + hit.u * mesh.normals[corner.y] + hit.v * mesh.normals[corner.z];
        if (!instance.identity) n = instance.normal_to_world * n;
        point.smooth_normal = turned_normal(n, point.geometric_normal);
        point.shading = Frame(normal_seen(point.smooth_normal, point.geometric_normal, ray_direction));
    }
    return point;
}

}  // namespace photond
