#include "renderer/transport/surface.h"

#include "renderer/scene/surface_color.h"

namespace photond {

namespace {

/// World-space tangent (not normalised) of a normal map's u axis and its handedness: the mesh's, else the direction in
/// which u grows over the triangle. Handedness 0 where there is neither.
struct TangentBasis {
    vec3 tangent{0};
    float handedness = 0;
};

TangentBasis tangent_basis(const Mesh& mesh, const Instance& instance, const ShadingPoint& point,
                           const TextureRef& normal_texture) {
    const uvec3 corner = mesh.triangles[point.triangle];
    const float w = 1.0f - point.u - point.v;
    TangentBasis basis;
    if (!mesh.tangents.empty()) {
        const vec4 t =
            w * mesh.tangents[corner.x] + point.u * mesh.tangents[corner.y] + point.v * mesh.tangents[corner.z];
        basis = {vec3(t), mesh.tangents[corner.x].w < 0 ? -1.0f : 1.0f};
    } else if (const std::vector<vec2>& uv = mesh.uv[normal_texture.uv_set]; !uv.empty()) {
        const vec2 uv1 = uv[corner.y] - uv[corner.x], uv2 = uv[corner.z] - uv[corner.x];
        const vec3 e1 = mesh.positions[corner.y] - mesh.positions[corner.x];
        const vec3 e2 = mesh.positions[corner.z] - mesh.positions[corner.x];
        const float determinant = uv1.x * uv2.y - uv1.y * uv2.x;
        if (determinant == 0.0f) return basis;
        // glTF's v runs down the image, a normal map's green axis up: the bitangent is -dp/dv (glTF 3.9.3, y up).
        basis = {(e1 * uv2.y - e2 * uv1.y) * std::copysign(1.0f, determinant), determinant < 0 ? 1.0f : -1.0f};
    }
    if (!instance.identity) basis.tangent = mat3(instance.to_world) * basis.tangent;
    // A mirroring transform turns cross(normal, tangent) against the image of the bitangent.
    if (instance.flips_orientation) basis.handedness = -basis.handedness;
    return basis;
}

}  // namespace

ShadingPoint make_shading_point(const Scene& scene, const Hit& hit, const vec3& ray_direction) {
    ShadingPoint point = make_plain_shading_point(scene, hit, ray_direction);
    const Material& material = scene.materials[point.material];
    if (!material.normal_texture.used()) return point;

    const Instance& instance = scene.instances[point.instance];
    const Mesh& mesh = scene.meshes[instance.mesh];
    const TangentBasis basis = tangent_basis(mesh, instance, point, material.normal_texture);
    // The map lies over the interpolated normal, whoever looks: over the normal seen it would make a third frame. It
    // describes the front: smooth normals of the back are turned there, and the mapped one turned back after.
    const vec3 n = point.front_side ? point.smooth_normal : -point.smooth_normal;
    const vec3 t = basis.tangent - n * glm::dot(n, basis.tangent);
    const float length_sq = glm::dot(t, t);
    if (basis.handedness == 0.0f || !(length_sq > 1e-30f)) return point;
    const vec3 tangent = t * (1.0f / std::sqrt(length_sq));
    const vec3 bitangent = glm::cross(n, tangent) * basis.handedness;

    const Texture& texture = scene.textures[static_cast<size_t>(material.normal_texture.texture)];
    const vec2 uv = texture_coordinates(mesh, material.normal_texture, point.triangle, point.u, point.v);
    const vec3 texel = 2.0f * vec3(sample_texture(texture, uv, false)) - 1.0f;
    const vec3 local(texel.x * material.normal_scale, texel.y * material.normal_scale, texel.z);
    const vec3 mapped = local.x * tangent + local.y * bitangent + local.z * n;
    point.smooth_normal = turned_normal(point.front_side ? mapped : -mapped, point.geometric_normal);
    point.shading = Frame(normal_seen(point.smooth_normal, point.geometric_normal, ray_direction));
    return point;
}

}  // namespace photond
