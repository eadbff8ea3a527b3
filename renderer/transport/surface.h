#pragma once
// From "this ray met that triangle" to what shading needs to know about the place.

#include "renderer/core/rgb.h"
#include "renderer/scene/intersector.h"
#include "renderer/scene/scene.h"

namespace photond {

/// A place on a surface, seen from one side. World space [m].
///
/// The geometric normal is turned to the side the ray came from; which side that is in the file's eyes says
/// `front_side`. The shading normal lies in the geometric normal's hemisphere and in the eye's: where an interpolated
/// or mapped normal would turn away from the eye, the frame is the geometric one (else such places were black).
struct SurfacePoint {
    vec3 position{0};
    vec3 geometric_normal{0, 0, 1};   // unit, on the eye's side
    Frame shading{vec3(0, 0, 1)};     // about the shading normal; tangents are arbitrary: all BSDFs are isotropic
    vec2 uv[2] = {vec2(0), vec2(0)};  // 0 where the mesh has none
    vec4 vertex_color{1};             // linear; 1 where the mesh has none
    uint32_t material = 0;
    bool front_side = true;  // the ray came from the side the triangle's winding faces
};

/// The surface at a valid hit of a ray with that (unit) direction. Every attribute and the normal map are looked up.
SurfacePoint make_surface_point(const Scene& scene, const Hit& hit, const vec3& ray_direction);

/// The same for scenes with Needs::only_lambert(), which read neither coordinates nor colours nor normal maps:
/// position, normals, side and material only. Equal to make_surface_point() there, bit by bit.
inline SurfacePoint make_plain_surface_point(const Scene& scene, const Hit& hit, const vec3& ray_direction);

/// Base colour (factor x texture x vertex colour), alpha in w, all in [0, 1] for factors in [0, 1].
vec4 base_color_at(const Scene& scene, const SurfacePoint& point);

/// Radiance emitted towards the eye's side [W m^-2 sr^-1]: 0 at the back of a single-sided surface.
Rgb emitted_radiance(const Scene& scene, const SurfacePoint& point);

/// How much of a surface is there: alpha of the base colour for blended materials, 0 or 1 for masked ones (compared
/// with the cut-off), 1 for opaque ones.
float alpha_at(const Scene& scene, const Hit& hit);

/// Where a ray that leaves the point towards `direction` starts, on the side it leaves to.
inline vec3 ray_origin(const SurfacePoint& point, const vec3& direction) {
    const bool eye_side = glm::dot(direction, point.geometric_normal) > 0;
    return offset_ray_origin(point.position, eye_side ? point.geometric_normal : -point.geometric_normal);
}

inline SurfacePoint make_plain_surface_point(const Scene& scene, const Hit& hit, const vec3& ray_direction) {
    const Instance& instance = scene.instances[hit.instance];
    const Mesh& mesh = scene.meshes[instance.mesh];
    const uvec3 corner = mesh.triangles[hit.triangle];
    vec3 p[3] = {mesh.positions[corner.x], mesh.positions[corner.y], mesh.positions[corner.z]};
    if (!instance.identity)
        for (vec3& q : p) q = instance.to_world * vec4(q, 1.0f);
    const float w = 1.0f - hit.u - hit.v;

    SurfacePoint point;
    point.material = mesh.material;
    // Interpolated rather than taken along the ray: its error is that of the corners, not of the distance.
    point.position = w * p[0] + hit.u * p[1] + hit.v * p[2];
    // Corners in world space turn the winding by themselves when the transform mirrors; glTF keeps the file's winding
    // as the front then (3.7.4), so the normal is turned back.
    vec3 ng = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
    if (instance.flips_orientation) ng = -ng;
    point.front_side = glm::dot(ng, ray_direction) < 0;
    point.geometric_normal = point.front_side ? ng : -ng;

    vec3 ns = point.geometric_normal;
    if (!mesh.normals.empty()) {
        vec3 n = w * mesh.normals[corner.x] + hit.u * mesh.normals[corner.y] + hit.v * mesh.normals[corner.z];
        if (!instance.identity) n = instance.normal_to_world * n;
        const float length_sq = glm::dot(n, n);
        if (length_sq > 0) {
            n *= 1.0f / std::sqrt(length_sq);
            if (glm::dot(n, point.geometric_normal) < 0) n = -n;
            if (glm::dot(n, ray_direction) < 0) ns = n;
        }
    }
    point.shading = Frame(ns);
    return point;
}

}  // namespace photond
