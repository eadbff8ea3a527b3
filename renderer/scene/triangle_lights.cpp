#include "renderer/scene/triangle_lights.h"

#include "renderer/scene/scene.h"
#include "renderer/scene/surface_color.h"

namespace photond {

namespace {

constexpr uint32_t kMinSamples = 256;
constexpr uint32_t kMaxSamples = 1u << 16;

/// Points a triangle's mean is taken over: about two a texel it covers, so that no texel is missed on a triangle of up
/// to kMaxSamples / 2 of them.
uint32_t samples_for(const Scene& scene, const Mesh& mesh, const TextureRef& reference, uint32_t triangle) {
    if (!reference.used()) return kMinSamples;
    const Size2 size = scene.textures[static_cast<size_t>(reference.texture)].size;
    const vec2 a = texture_coordinates(mesh, reference, triangle, 0, 0);
    const vec2 b = texture_coordinates(mesh, reference, triangle, 1, 0) - a;
    const vec2 c = texture_coordinates(mesh, reference, triangle, 0, 1) - a;
    const double texels = 0.5 * std::abs(double{b.x} * c.y - double{b.y} * c.x) * size.width * size.height;
    return static_cast<uint32_t>(std::clamp(2 * texels, double{kMinSamples}, double{kMaxSamples}));
}

/// Mean of emission x coverage over a triangle whose material varies.
/// Points: the R2 sequence (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences"), folded into the
/// triangle; the same for every triangle and run.
Rgb mean_emission(const Scene& scene, const Mesh& mesh, uint32_t triangle) {
    const Material& material = scene.materials[mesh.material];
    uint32_t count = samples_for(scene, mesh, material.emission_texture, triangle);
    if (material.alpha_mode != AlphaMode::Opaque)
        count = std::max(count, samples_for(scene, mesh, material.base_color_texture, triangle));
    dvec3 sum(0);
    double x = 0.5, y = 0.5;
    for (uint32_t i = 0; i < count; ++i) {
        x += 0.75487766624669276, y += 0.56984029099805327;
        x -= std::floor(x), y -= std::floor(y);
        const bool outside = x + y > 1;
        const float u = static_cast<float>(outside ? 1 - x : x), v = static_cast<float>(outside ? 1 - y : y);
        sum += dvec3(surface_emission(scene, mesh, triangle, u, v) * surface_coverage(scene, mesh, triangle, u, v));
    }
    return Rgb(sum / static_cast<double>(count));
}

bool emission_varies(const Material& material) {
    return material.emission_texture.used() || material.alpha_mode != AlphaMode::Opaque;
}

}  // namespace

std::vector<TriangleLight> find_triangle_lights(const Scene& scene) {
    std::vector<TriangleLight> lights;
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
        const Material& material = scene.materials[mesh.material];
        if (!material.emissive() || material.unlit) continue;
        for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const TriangleCorners corners = world_triangle(scene, i, t);
            const dvec3 cross =
                glm::cross(dvec3(corners.p[1]) - dvec3(corners.p[0]), dvec3(corners.p[2]) - dvec3(corners.p[0]));
            const float area_m2 = static_cast<float>(0.5 * glm::length(cross));
            if (!(area_m2 > 0)) continue;
            const Rgb radiance = emission_varies(material) ? mean_emission(scene, mesh, t) : material.emission;
            if (max_component(radiance) > 0) lights.push_back({i, t, area_m2, radiance, material.double_sided});
        }
    }
    lights.shrink_to_fit();
    return lights;
}

}  // namespace photond
