#pragma once
// glTF metallic-roughness with its extensions (conventions.md, "Materials"), as plain numbers and texture references.

#include <string>

#include "renderer/scene/texture.h"

namespace photond {

enum class AlphaMode : uint8_t { Opaque, Mask, Blend };

struct Material {
    std::string name;
    Rgb base_color{1};
    float alpha = 1;
    TextureRef base_color_texture;  // rgb sRGB, a linear
    float metallic = 1;
    float roughness = 1;                    // alpha of GGX is its square
    TextureRef metallic_roughness_texture;  // g roughness, b metallic, linear
    TextureRef normal_texture;              // linear
    float normal_scale = 1;
    Rgb emission{0};                    // factor x strength [W m^-2 sr^-1]
    TextureRef emission_texture;        // sRGB
    float ior = 1.5f;                   // KHR_materials_ior
    float specular = 1;                 // KHR_materials_specular: specularFactor; 0 on a non-metal is pure Lambert
    Rgb specular_color{1};              // specularColorFactor
    TextureRef specular_texture;        // a, linear
    TextureRef specular_color_texture;  // rgb sRGB
    float transmission = 0;             // KHR_materials_transmission
    TextureRef transmission_texture;    // r, linear
    bool solid = false;        // KHR_materials_volume with thickness > 0: a closed mesh that refracts and absorbs
    Rgb attenuation_color{1};  // of light after attenuation_distance [m] inside; Beer's law
    float attenuation_distance = kInfinity;
    AlphaMode alpha_mode = AlphaMode::Opaque;
    float alpha_cutoff = 0.5f;
    bool double_sided = false;  // decides emission only: no ray is culled
    bool unlit = false;         // KHR_materials_unlit: emits base_color as radiance to the eye, and reflects nothing

    bool emissive() const { return max_component(emission) > 0; }
};

/// Calls visitor(TextureRef&) for each texture reference of a material.
template <class AnyMaterial, class Visitor>
void visit_texture_refs(AnyMaterial& material, const Visitor& visitor) {
    visitor(material.base_color_texture), visitor(material.metallic_roughness_texture),
        visitor(material.normal_texture);
    visitor(material.emission_texture), visitor(material.specular_texture), visitor(material.specular_color_texture);
    visitor(material.transmission_texture);
}

}  // namespace photond
