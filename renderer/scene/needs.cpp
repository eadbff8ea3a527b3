#include "renderer/scene/needs.h"

#include "renderer/scene/delta_shared.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

/// Least and greatest value of one channel over a texture, in [0, 1].
struct ChannelRange {
    float min = 1;
    float max = 1;
};

ChannelRange channel_range(const Scene& scene, const TextureRef& reference, int channel) {
    if (!reference.used()) return {};
    const Texture& texture = scene.textures[static_cast<size_t>(reference.texture)];
    uint8_t least = 255, greatest = 0;
    for (const u8vec4& texel : texture.texels) {
        least = std::min(least, texel[channel]);
        greatest = std::max(greatest, texel[channel]);
    }
    return {static_cast<float>(least) / 255, static_cast<float>(greatest) / 255};
}

/// What one material adds. Textures are looked through, so that a map which never leads below the delta limit, or never
/// away from full coverage, asks for nothing.
void add_material_needs(const Scene& scene, const Material& material, bool vertex_colors, Needs& needs) {
    const bool masks = material.alpha_mode != AlphaMode::Opaque;
    if (masks)
        needs.alpha |= material.alpha < 1 || vertex_colors ||
                       channel_range(scene, material.base_color_texture, 3).min < 1 || material.alpha_cutoff > 1;
    if (material.base_color_texture.used()) needs.base_color_textures = true;
    if (material.unlit) {
        needs.unlit = true;
        return;  // nothing else of an unlit material is looked at
    }
    const ChannelRange g = channel_range(scene, material.metallic_roughness_texture, 1);
    const ChannelRange b = channel_range(scene, material.metallic_roughness_texture, 2);
    const float least_metallic = material.metallic * b.min, most_metallic = material.metallic * b.max;
    const float least_roughness = material.roughness * g.min, most_roughness = material.roughness * g.max;
    const bool dielectric = least_metallic < 1;
    const bool metal = most_metallic > 0;  // a black one too: at grazing angles Schlick's Fresnel term goes to 1
    const bool dielectric_lobe =
        dielectric && material.specular > 0 && channel_range(scene, material.specular_texture, 3).max > 0;
    const float least_transmission = material.transmission * channel_range(scene, material.transmission_texture, 0).min;
    const bool transmits =
        dielectric && material.transmission > 0 && channel_range(scene, material.transmission_texture, 0).max > 0;

    if (metal || dielectric_lobe || transmits) {
        const bool hardly_bends =
            transmits && material.solid && sqr(least_roughness) * std::fabs(material.ior - 1) < DELTA_REFRACTION;
        needs.delta |= least_roughness < DELTA_ROUGHNESS || hardly_bends;
        if (most_roughness >= DELTA_ROUGHNESS) {
            needs.glossy = true;
            needs.least_glossy_alpha =
                std::min(needs.least_glossy_alpha, sqr(std::max(least_roughness, DELTA_ROUGHNESS)));
        }
    }
    needs.transmission |= transmits;
    needs.solid_glass |= transmits && material.solid;
    needs.diffuse |= dielectric && least_transmission < 1 && max_component(material.base_color) > 0;
    needs.normal_maps |= material.normal_texture.used();
    needs.material_textures |= material.metallic_roughness_texture.used() || material.specular_texture.used() ||
                               material.specular_color_texture.used() || material.transmission_texture.used();
    needs.emission_textures |= material.emissive() && material.emission_texture.used();
}

}  // namespace

Needs find_needs(const Scene& scene) {
    Needs needs;
    std::vector<uint32_t> uses(scene.meshes.size(), 0);
    for (const Instance& instance : scene.instances) ++uses[instance.mesh];

    uint32_t solids = 0;                                                // as placed
    std::vector<uint8_t> material_seen(2 * scene.materials.size(), 0);  // without and with vertex colours
    for (size_t m = 0; m < scene.meshes.size(); ++m) {
        const Mesh& mesh = scene.meshes[m];
        if (uses[m] == 0 || mesh.triangles.empty()) continue;
        needs.instances |= uses[m] > 1;
        needs.vertex_colors |= !mesh.colors.empty();
        if (scene.materials[mesh.material].solid) solids += uses[m];
        uint8_t& seen = material_seen[2 * mesh.material + (mesh.colors.empty() ? 0 : 1)];
        if (!seen) add_material_needs(scene, scene.materials[mesh.material], !mesh.colors.empty(), needs);
        seen = 1;
    }
    // Where one solid lies within another, a surface, however rough, may bend nothing: light goes straight through.
    needs.delta |= needs.solid_glass && solids > 1;
    find_light_needs(scene, needs);
    return needs;
}

void find_light_needs(const Scene& scene, Needs& needs) {
    needs.area_lights = !scene.triangle_lights.empty();
    needs.punctual_lights = !scene.punctual_lights.empty();
    needs.environment = scene.environment.has_value();
}

}  // namespace photond
