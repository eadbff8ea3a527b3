// Materials of a document: core metallic-roughness and the KHR extensions (conventions.md, "Materials"), into Material.

#include <cmath>

#include "renderer/scene/gltf_document.h"

namespace photond {

namespace {

constexpr double kAny = JsonRef::kAnyNumber;

float number(const JsonRef& place, std::string_view key, float fallback, double min, double max) {
    return static_cast<float>(place.number_or(key, fallback, min, max));
}

Rgb color(const JsonRef& place, std::string_view key, const Rgb& fallback, double max) {
    double rgb[3];
    if (!place.numbers(key, rgb, 0, max)) return fallback;
    return Rgb(static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2]));
}

/// KHR_texture_transform: uv' = translation * rotation * scale * uv, as its text gives the matrices.
void read_texture_transform(const JsonRef& place, TextureRef& reference) {
    double offset[2] = {0, 0}, scale[2] = {1, 1};
    place.numbers("offset", offset, -kAny, kAny);
    place.numbers("scale", scale, -kAny, kAny);
    const double angle = place.number_or("rotation", 0, -kAny, kAny);  // counter-clockwise in uv with v down
    const double c = std::cos(angle), s = std::sin(angle);
    reference.row_u = vec3(dvec3(c * scale[0], s * scale[1], offset[0]));
    reference.row_v = vec3(dvec3(-s * scale[0], c * scale[1], offset[1]));
    if (!is_finite(reference.row_u) || !is_finite(reference.row_v)) place.fail("the transform is not finite");
    reference.uv_set = static_cast<uint32_t>(place.whole_or("texCoord", reference.uv_set, 0, 65535));
}

TextureRef read_texture_ref(const JsonRef& material, std::string_view key, const GltfDocument& document) {
    TextureRef reference;
    const auto place = material.find(key);
    if (!place) return reference;
    const JsonRef index = place->require("index");
    const uint32_t texture = index.index(document.textures.size(), "textures");
    reference.texture = static_cast<int32_t>(texture);
    reference.uv_set = static_cast<uint32_t>(place->whole_or("texCoord", 0, 0, 65535));
    if (const auto transform = place->extension("KHR_texture_transform")) read_texture_transform(*transform, reference);
    if (!document.textures[texture].image)
        index.fail("texture " + std::to_string(texture) + " has no source image in a supported format",
                   ErrorCode::Unsupported);
    return reference;
}

void read_metallic_roughness(const JsonRef& place, const GltfDocument& document, Material& m) {
    double rgba[4];
    if (place.numbers("baseColorFactor", rgba, 0, 1)) {
        m.base_color = Rgb(static_cast<float>(rgba[0]), static_cast<float>(rgba[1]), static_cast<float>(rgba[2]));
        m.alpha = static_cast<float>(rgba[3]);
    }
    m.base_color_texture = read_texture_ref(place, "baseColorTexture", document);
    m.metallic = number(place, "metallicFactor", 1, 0, 1);
    m.roughness = number(place, "roughnessFactor", 1, 0, 1);
    m.metallic_roughness_texture = read_texture_ref(place, "metallicRoughnessTexture", document);
}

void read_emission(const JsonRef& place, const GltfDocument& document, Material& m) {
    double strength = 1;
    if (const auto extension = place.extension("KHR_materials_emissive_strength"))
        strength = extension->number_or("emissiveStrength", 1, 0, kAny);
    // The factor's range of 1 predates the strength extension and files pass it; radiance has no upper bound here.
    m.emission = color(place, "emissiveFactor", Rgb(0), kAny) * static_cast<float>(strength);
    if (!is_finite(m.emission)) place.fail("emissiveFactor x emissiveStrength is not finite");
    m.emission_texture = read_texture_ref(place, "emissiveTexture", document);
}

void read_dielectric(const JsonRef& place, const GltfDocument& document, Material& m) {
    if (const auto extension = place.extension("KHR_materials_ior")) {
        if (const auto ior = extension->find("ior")) {
            m.ior = static_cast<float>(ior->number(0, kAny));
            if (m.ior != 0 && m.ior < 1) ior->fail("must be 0 or at least 1, not " + std::to_string(m.ior));
        }
    }
    if (const auto extension = place.extension("KHR_materials_specular")) {
        m.specular = number(*extension, "specularFactor", 1, 0, 1);
        m.specular_color = color(*extension, "specularColorFactor", Rgb(1), kAny);
        m.specular_texture = read_texture_ref(*extension, "specularTexture", document);
        m.specular_color_texture = read_texture_ref(*extension, "specularColorTexture", document);
    }
    if (const auto extension = place.extension("KHR_materials_transmission")) {
        m.transmission = number(*extension, "transmissionFactor", 0, 0, 1);
        m.transmission_texture = read_texture_ref(*extension, "transmissionTexture", document);
        if (m.transmission > 0 && m.ior == 0)
            extension->fail("a transmissive material cannot have an index of refraction of 0", ErrorCode::Unsupported);
    }
    if (const auto extension = place.extension("KHR_materials_volume")) {
        m.solid = extension->number_or("thicknessFactor", 0, 0, kAny) > 0;
        m.attenuation_color = color(*extension, "attenuationColor", Rgb(1), 1);
        if (const auto distance = extension->find("attenuationDistance")) {
            const double d = distance->number(0, kAny);
            m.attenuation_distance = static_cast<float>(d);
            if (!(m.attenuation_distance > 0)) distance->fail("must be greater than 0");
        }
    }
}

void read_alpha(const JsonRef& place, Material& m) {
    if (const auto mode = place.find("alphaMode")) {
        const std::string_view word = mode->text();
        if (word == "MASK")
            m.alpha_mode = AlphaMode::Mask;
        else if (word == "BLEND")
            m.alpha_mode = AlphaMode::Blend;
        else if (word != "OPAQUE")
            mode->fail("\"" + std::string(word.substr(0, 60)) + "\" is none of OPAQUE, MASK, BLEND");
    }
    m.alpha_cutoff = number(place, "alphaCutoff", 0.5f, 0, kAny);
}

/// A texture that is multiplied by nothing, or perturbs nothing, need not be loaded.
void drop_textures_without_effect(Material& m) {
    if (!m.emissive()) m.emission_texture = {};
    if (m.specular == 0) m.specular_texture = m.specular_color_texture = {};
    if (m.transmission == 0) m.transmission_texture = {};
    if (m.normal_scale == 0) m.normal_texture = {};
    if (m.unlit)
        m.metallic_roughness_texture = m.normal_texture = m.emission_texture = m.specular_texture =
            m.specular_color_texture = m.transmission_texture = {};
}

Material read_material(const JsonRef& place, const GltfDocument& document) {
    Material m;
    m.name = place.text_or("name", "");
    if (const auto pbr = place.find("pbrMetallicRoughness")) read_metallic_roughness(*pbr, document, m);
    m.normal_texture = read_texture_ref(place, "normalTexture", document);
    if (const auto normal = place.find("normalTexture")) m.normal_scale = number(*normal, "scale", 1, -kAny, kAny);
    read_texture_ref(place, "occlusionTexture", document);  // checked only: occlusion is what we compute
    read_emission(place, document, m);
    read_dielectric(place, document, m);
    read_alpha(place, m);
    m.double_sided = place.boolean_or("doubleSided", false);
    if (place.extension("KHR_materials_unlit")) m.unlit = true;
    drop_textures_without_effect(m);
    return m;
}

}  // namespace

void read_gltf_materials(const JsonRef& root, GltfDocument& document, FaultList& faults) {
    faults.collect([&] {
        const auto materials = root.find("materials");
        if (!materials) return;
        document.materials.resize(materials->array_size());
        for (uint32_t i = 0; i < document.materials.size(); ++i)
            faults.collect([&] { document.materials[i] = read_material(materials->at(i), document); });
    });
}

}  // namespace photond
