// GLSL twin of transport/surface.h and surface.cpp: from "this ray met that triangle" to what shading needs to know
// about the place.
#ifndef PHOTOND_SURFACE_GLSL
#define PHOTOND_SURFACE_GLSL

#include "renderer/backends/gpu/bvh.glsl"
#include "renderer/core/geometry.glsl"
#include "renderer/scene/surface_color.glsl"
#include "renderer/transport/ray_start.glsl"

/// A hit made ready for shading, seen from the side the ray came from, as surface.h says.
struct ShadingPoint {
    vec3 position;          // world space [m]; clearance_m off the triangle, on the ray's side
    vec3 geometric_normal;  // unit, on the ray's side
    vec3 smooth_normal;     // unit, on the geometric normal's side
    Frame shading;          // about normal_seen(); its tangents are arbitrary, as all BSDFs are isotropic
    uint instance;
    uint triangle;
    float u;  // barycentrics, as in Hit
    float v;
    uint material;
    float clearance_m;  // surface_clearance()
    bool front_side;  // the ray came from the side the triangle's winding faces
};

/// Where a ray that leaves the point towards `direction` (unit) starts, on the side it leaves to.
vec3 ray_origin(ShadingPoint point, vec3 direction) {
    const vec3 n = point.geometric_normal;
    if (dot(direction, n) > 0.0) return step_off(point.position, n);
    return step_off(point.position - 2.0 * point.clearance_m * n, -n);
}

/// `normal` (of any length) made unit and turned to the geometric normal's side; the geometric normal where it is
/// degenerate.
vec3 turned_normal(vec3 normal, vec3 geometric_normal) {
    const float length_sq = dot(normal, normal);
    if (!(length_sq > 1e-30)) return geometric_normal;
    const float side = dot(normal, geometric_normal) < 0.0 ? -1.0 : 1.0;
    return normal * (side / sqrt(length_sq));
}

/// The normal that an eye looking along `ray_direction` shades with, both normals being on its side of the surface.
vec3 normal_seen(vec3 smooth_normal, vec3 geometric_normal, vec3 ray_direction) {
    return dot(smooth_normal, ray_direction) < 0.0 ? smooth_normal : geometric_normal;
}

/// a b and what float leaves of it, by halves that multiply without rounding.
/// [Dekker 1971] A Floating-Point Technique for Extending the Available Precision. Numerische Mathematik 18(3).
vec2 exact_product(float a, float b) {
    precise const float split_a = 4097.0 * a, split_b = 4097.0 * b;
    precise const float a1 = split_a - (split_a - a), b1 = split_b - (split_b - b);
    precise const float a2 = a - a1, b2 = b - b1;
    precise const float product = a * b;
    precise const float rest = ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2;
    return vec2(product, rest);
}
float difference_of_products(float a, float b, float c, float d) {
    const vec2 ab = exact_product(a, b), cd = exact_product(c, d);
    precise const float difference = (ab.x - cd.x) + (ab.y - cd.y);
    return difference;
}

/// The power of two that brings the largest component near 1; 1 for what is 0 or infinite.
float scale_to_one(vec3 v) {
    const uint exponent = floatBitsToUint(max_component(abs(v))) >> 23;
    return exponent == 0u || exponent > 253u ? 1.0 : uintBitsToFloat((254u - exponent) << 23);
}

/// Unit normal of two edges. With scaled edges and exact products, in place of the twin's double, which not all devices
/// have, where the square of a tiny or needle-like triangle's area leaves float's range.
vec3 unit_cross(vec3 a, vec3 b) {
    const vec3 n = cross(a, b);
    const float length_sq = dot(n, n);
    if (length_sq > 1e-30 && length_sq < INFINITY) return n * (1.0 / sqrt(length_sq));
    a *= scale_to_one(a);
    b *= scale_to_one(b);
    const vec3 exact = vec3(difference_of_products(a.y, b.z, b.y, a.z), difference_of_products(a.z, b.x, b.z, a.x),
                            difference_of_products(a.x, b.y, b.x, a.y));
    return normalize(exact * scale_to_one(exact));
}

/// make_shading_point() before the normal map.
ShadingPoint make_plain_shading_point(Hit hit, vec3 ray_direction) {
    const uint mesh = mesh_of(hit.instance);
    const uvec3 corner = triangle_corners(mesh, hit.triangle);
    const TriangleCorners corners = world_triangle(hit.instance, hit.triangle);
    const float w = 1.0 - hit.u - hit.v;

    ShadingPoint point;
    point.instance = hit.instance;
    point.triangle = hit.triangle;
    point.u = hit.u;
    point.v = hit.v;
    point.material = scene_meshes[mesh].material;
    point.clearance_m = surface_clearance(corners.p[0], corners.p[1], corners.p[2]);
    vec3 ng = unit_cross(corners.p[1] - corners.p[0], corners.p[2] - corners.p[0]);
    if (flips_orientation(hit.instance)) ng = -ng;
    point.front_side = dot(ng, ray_direction) < 0.0;
    point.geometric_normal = point.front_side ? ng : -ng;
    // Interpolated rather than taken along the ray: its error is that of the corners, not that of the distance.
    point.position = w * corners.p[0] + hit.u * corners.p[1] + hit.v * corners.p[2] +
                     point.clearance_m * point.geometric_normal;
    point.smooth_normal = point.geometric_normal;
    vec3 seen = point.geometric_normal;
    if (NEEDS_SMOOTH_NORMALS) {
        const uint normals = scene_meshes[mesh].normals;
        if (normals != NO_ATTRIBUTE) {
            const uint stride = scene_meshes[mesh].attribute_stride;
            vec3 n = w * attribute_vec3(normals, stride, corner.x) + hit.u * attribute_vec3(normals, stride, corner.y) +
                     hit.v * attribute_vec3(normals, stride, corner.z);
            if (is_transformed(hit.instance)) n = scene_instances[hit.instance].normal_to_world * n;
            point.smooth_normal = turned_normal(n, point.geometric_normal);
            seen = normal_seen(point.smooth_normal, point.geometric_normal, ray_direction);
        }
    }
    point.shading = make_frame(seen);
    return point;
}

/// World-space tangent (not normalised) of a normal map's u axis and its handedness: the mesh's, else the direction in
/// which u grows over the triangle. Handedness 0 where there is neither.
struct TangentBasis {
    vec3 tangent;
    float handedness;
};

TangentBasis tangent_basis(ShadingPoint point, uint uv_set) {
    const uint mesh = mesh_of(point.instance);
    const uvec3 corner = triangle_corners(mesh, point.triangle);
    const float w = 1.0 - point.u - point.v;
    const uint stride = scene_meshes[mesh].attribute_stride;
    const uint tangents = scene_meshes[mesh].tangents;
    const uint uv = uv_set == 0u ? scene_meshes[mesh].uv[0] : scene_meshes[mesh].uv[1];
    TangentBasis basis = TangentBasis(vec3(0.0), 0.0);
    if (tangents != NO_ATTRIBUTE) {
        const vec4 first = attribute_vec4(tangents, stride, corner.x);
        const vec4 t = w * first + point.u * attribute_vec4(tangents, stride, corner.y) +
                       point.v * attribute_vec4(tangents, stride, corner.z);
        basis = TangentBasis(t.xyz, first.w < 0.0 ? -1.0 : 1.0);
    } else if (uv != NO_ATTRIBUTE) {
        const vec2 uv0 = attribute_vec2(uv, stride, corner.x);
        const vec2 uv1 = attribute_vec2(uv, stride, corner.y) - uv0, uv2 = attribute_vec2(uv, stride, corner.z) - uv0;
        const uvec3 vertex = scene_meshes[mesh].first_vertex + corner;
        const vec3 e1 = scene_positions[vertex.y] - scene_positions[vertex.x];
        const vec3 e2 = scene_positions[vertex.z] - scene_positions[vertex.x];
        const float determinant = uv1.x * uv2.y - uv1.y * uv2.x;
        if (determinant == 0.0) return basis;
        // glTF's v runs down the image, a normal map's green axis up: the bitangent is -dp/dv (glTF 3.9.3, y up).
        basis = TangentBasis((e1 * uv2.y - e2 * uv1.y) * (determinant < 0.0 ? -1.0 : 1.0),
                             determinant < 0.0 ? 1.0 : -1.0);
    }
    if (is_transformed(point.instance)) basis.tangent = mat3(scene_instances[point.instance].to_world) * basis.tangent;
    // A mirroring transform turns cross(normal, tangent) against the image of the bitangent.
    if (flips_orientation(point.instance)) basis.handedness = -basis.handedness;
    return basis;
}

/// The surface at a valid hit of a ray with that (unit) direction, normal map included.
ShadingPoint make_shading_point(Hit hit, vec3 ray_direction) {
    ShadingPoint point = make_plain_shading_point(hit, ray_direction);
    if (!NEEDS_NORMAL_MAPS) return point;
    const TextureRefRecord normal_texture = scene_materials[point.material].normal_texture;
    if (!texture_used(normal_texture)) return point;

    const TangentBasis basis = tangent_basis(point, normal_texture.uv_set);
    // The map lies over the interpolated normal, whoever looks: over the normal seen it would make a third frame. It
    // describes the front: smooth normals of the back are turned there, and the mapped one turned back after.
    const vec3 n = point.front_side ? point.smooth_normal : -point.smooth_normal;
    const vec3 t = basis.tangent - n * dot(n, basis.tangent);
    const float length_sq = dot(t, t);
    if (basis.handedness == 0.0 || !(length_sq > 1e-30)) return point;
    const vec3 tangent = t * (1.0 / sqrt(length_sq));
    const vec3 bitangent = cross(n, tangent) * basis.handedness;

    const vec2 uv = texture_coordinates(mesh_of(point.instance), normal_texture, point.triangle, point.u, point.v);
    const vec3 texel = 2.0 * sample_texture(normal_texture.texture, uv, false).xyz - 1.0;
    const float normal_scale = scene_materials[point.material].normal_scale;
    const vec3 local = vec3(texel.x * normal_scale, texel.y * normal_scale, texel.z);
    const vec3 mapped = local.x * tangent + local.y * bitangent + local.z * n;
    point.smooth_normal = turned_normal(point.front_side ? mapped : -mapped, point.geometric_normal);
    point.shading = make_frame(normal_seen(point.smooth_normal, point.geometric_normal, ray_direction));
    return point;
}

#endif
