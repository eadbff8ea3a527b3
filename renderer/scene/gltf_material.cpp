// Materials of a document: core metallic-roughness and the KHR extensions (conventions.md, "Materials"), into Material.

#include <cmath>

#include "renderer/scene/gltf_document.h"

namespace photond {

namespace {

using tinygltf::Value;

double number(const Value& place, const std::string& key, double fallback) {
    return place.Has(key) ? place.Get(key).GetNumberAsDouble() : fallback;
}

Rgb color(const std::vector<double>& rgb) { return Rgb(dvec3(rgb[0], rgb[1], rgb[2])); }

std::vector<double> numbers(const Value& place, const std::string& key, std::vector<double> fallback) {
    for (size_t i = 0; place.Has(key) && i < fallback.size(); ++i)
        fallback[i] = place.Get(key).Get(static_cast<int>(i)).GetNumberAsDouble();
    return fallback;
}

/// How a reference is transformed; null: not at all.
TextureTransform transform_of(const Value* stored) {
    TextureTransform transform;
    if (stored == nullptr) return transform;
    const std::vector<double> offset = numbers(*stored, "offset", {0, 0}), scale = numbers(*stored, "scale", {1, 1});
    transform.offset = {offset[0], offset[1], 0};
    transform.scale = {scale[0], scale[1], 0};
    transform.rotation = number(*stored, "rotation", 0);
    return transform;
}

TextureRef texture_ref(int texture, int uv_set, const Value* transform) {
    TextureRef reference;
    if (texture < 0) return reference;
    reference.texture = texture;
    if (transform != nullptr) {
        transform_of(transform).apply(reference);
        uv_set = static_cast<int>(number(*transform, "texCoord", uv_set));
    }
    reference.uv_set = static_cast<uint32_t>(uv_set);
    return reference;
}

template <class TextureInfo>
const Value* transform_at(const TextureInfo& info) {
    return gltf_extension(info.extensions, "KHR_texture_transform");
}

/// Of a texture that an extension names, whose values tinygltf leaves as they are.
const Value* transform_at(const Value& extension, const std::string& key) {
    const Value& info = extension.Get(key);
    const bool transformed =
        info.IsObject() && info.Has("extensions") && info.Get("extensions").Has("KHR_texture_transform");
    return transformed ? &info.Get("extensions").Get("KHR_texture_transform") : nullptr;
}

template <class TextureInfo>
TextureRef texture_ref(const TextureInfo& info) {
    return texture_ref(info.index, info.texCoord, transform_at(info));
}

TextureRef texture_ref(const Value& extension, const std::string& key) {
    const Value& info = extension.Get(key);
    if (!info.IsObject()) return {};
    return texture_ref(info.Get("index").GetNumberAsInt(), static_cast<int>(number(info, "texCoord", 0)),
                       transform_at(extension, key));
}

void read_extensions(const tinygltf::ExtensionMap& extensions, Material& m) {
    const auto with = [&](const char* name, const auto& read) {
        if (const Value* extension = gltf_extension(extensions, std::string("KHR_materials_") + name)) read(*extension);
    };
    with("emissive_strength",
         [&](const Value& e) { m.emission *= static_cast<float>(number(e, "emissiveStrength", 1)); });
    with("ior", [&](const Value& e) { m.ior = static_cast<float>(number(e, "ior", 1.5)); });
    with("specular", [&](const Value& e) {
        m.specular = static_cast<float>(number(e, "specularFactor", 1));
        m.specular_color = color(numbers(e, "specularColorFactor", {1, 1, 1}));
        m.specular_texture = texture_ref(e, "specularTexture");
        m.specular_color_texture = texture_ref(e, "specularColorTexture");
    });
    with("transmission", [&](const Value& e) {
        m.transmission = static_cast<float>(number(e, "transmissionFactor", 0));
        m.transmission_texture = texture_ref(e, "transmissionTexture");
    });
    with("volume", [&](const Value& e) {
        m.solid = number(e, "thicknessFactor", 0) > 0;
        m.attenuation_color = color(numbers(e, "attenuationColor", {1, 1, 1}));
        m.attenuation_distance = static_cast<float>(number(e, "attenuationDistance", kInfinity));
    });
    with("unlit", [&](const Value&) { m.unlit = true; });
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

}  // namespace

Material read_gltf_material(const tinygltf::Material& material, bool animated) {
    const tinygltf::PbrMetallicRoughness& pbr = material.pbrMetallicRoughness;
    Material m;
    m.name = material.name;
    m.base_color = color(pbr.baseColorFactor);
    m.alpha = static_cast<float>(pbr.baseColorFactor[3]);
    m.base_color_texture = texture_ref(pbr.baseColorTexture);
    m.metallic = static_cast<float>(pbr.metallicFactor);
    m.roughness = static_cast<float>(pbr.roughnessFactor);
    m.metallic_roughness_texture = texture_ref(pbr.metallicRoughnessTexture);
    m.normal_texture = texture_ref(material.normalTexture);
    m.normal_scale = static_cast<float>(material.normalTexture.scale);
    m.emission = color(material.emissiveFactor);
    m.emission_texture = texture_ref(material.emissiveTexture);
    if (material.alphaMode == "MASK") m.alpha_mode = AlphaMode::Mask;
    if (material.alphaMode == "BLEND") m.alpha_mode = AlphaMode::Blend;
    m.alpha_cutoff = static_cast<float>(material.alphaCutoff);
    m.double_sided = material.doubleSided;
    read_extensions(material.extensions, m);
    if (!animated) drop_textures_without_effect(m);
    return m;
}

RiggedMaterial read_rigged_material(const tinygltf::Material& material) {
    RiggedMaterial rigged;
    const std::vector<double>& emission = material.emissiveFactor;
    rigged.emissive_factor = {emission[0], emission[1], emission[2]};
    const auto extension = [&](const char* name) {
        return gltf_extension(material.extensions, std::string("KHR_materials_") + name);
    };
    if (const Value* strength = extension("emissive_strength"))
        rigged.emissive_strength = number(*strength, "emissiveStrength", 1);
    const Value *specular = extension("specular"), *transmission = extension("transmission");
    const Value* const transforms[kTextureSlots] = {
        transform_at(material.pbrMetallicRoughness.baseColorTexture),
        transform_at(material.pbrMetallicRoughness.metallicRoughnessTexture),
        transform_at(material.normalTexture),
        transform_at(material.emissiveTexture),
        specular == nullptr ? nullptr : transform_at(*specular, "specularTexture"),
        specular == nullptr ? nullptr : transform_at(*specular, "specularColorTexture"),
        transmission == nullptr ? nullptr : transform_at(*transmission, "transmissionTexture"),
    };
    for (uint32_t slot = 0; slot < kTextureSlots; ++slot) rigged.transforms[slot] = transform_of(transforms[slot]);
    return rigged;
}

}  // namespace photond
