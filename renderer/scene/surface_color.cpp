#include "renderer/scene/surface_color.h"

#include "renderer/scene/scene.h"

namespace photond {

namespace {

template <class T>
T interpolate(const std::vector<T>& attribute, const uvec3& corner, float u, float v) {
    return (1 - u - v) * attribute[corner.x] + u * attribute[corner.y] + v * attribute[corner.z];
}

}  // namespace

vec2 texture_coordinates(const Mesh& mesh, const TextureRef& reference, uint32_t triangle, float u, float v) {
    const std::vector<vec2>& uv = mesh.uv[reference.uv_set];
    const vec2 st = uv.empty() ? vec2(0) : interpolate(uv, mesh.triangles[triangle], u, v);
    return {glm::dot(reference.row_u, vec3(st, 1)), glm::dot(reference.row_v, vec3(st, 1))};
}

Rgb surface_emission(const Scene& scene, const Mesh& mesh, uint32_t triangle, float u, float v) {
    const Material& material = scene.materials[mesh.material];
    const TextureRef& reference = material.emission_texture;
    if (!reference.used() || !material.emissive()) return material.emission;
    const Texture& texture = scene.textures[static_cast<size_t>(reference.texture)];
    return material.emission * Rgb(sample_texture(texture, texture_coordinates(mesh, reference, triangle, u, v), true));
}

vec4 surface_base_color(const Scene& scene, const Mesh& mesh, uint32_t triangle, float u, float v) {
    const Material& material = scene.materials[mesh.material];
    vec4 color(material.base_color, material.alpha);
    if (const TextureRef& reference = material.base_color_texture; reference.used()) {
        const Texture& texture = scene.textures[static_cast<size_t>(reference.texture)];
        color *= sample_texture(texture, texture_coordinates(mesh, reference, triangle, u, v), true);
    }
    if (!mesh.colors.empty()) color *= interpolate(mesh.colors, mesh.triangles[triangle], u, v);
    return color;
}

void prefetch_base_color(const Scene& scene, const Mesh& mesh, uint32_t triangle, float u, float v) {
    const TextureRef& reference = scene.materials[mesh.material].base_color_texture;
    if (!reference.used()) return;
    prefetch_texture(scene.textures[static_cast<size_t>(reference.texture)],
                     texture_coordinates(mesh, reference, triangle, u, v));
}

float surface_coverage(const Scene& scene, const Mesh& mesh, uint32_t triangle, float u, float v) {
    const Material& material = scene.materials[mesh.material];
    if (material.alpha_mode == AlphaMode::Opaque) return 1.0f;
    const float alpha = surface_base_color(scene, mesh, triangle, u, v).w;
    if (material.alpha_mode == AlphaMode::Mask) return alpha >= material.alpha_cutoff ? 1.0f : 0.0f;
    return std::clamp(alpha, 0.0f, 1.0f);
}

}  // namespace photond
