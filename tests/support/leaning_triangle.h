#pragma once
// A triangle whose normals lean or not, of every kind of material: where light must be scattered as the eye sees it.

#include <vector>

#include "renderer/scene/scene.h"
#include "renderer/transport/bsdf.h"

namespace photond::test {

constexpr float kThreshold = 0.05f;  // alpha

enum class Normals { Flat, Leaning, Mapped, LeaningAndMapped };
inline constexpr Normals kAllNormals[] = {Normals::Flat, Normals::Leaning, Normals::Mapped, Normals::LeaningAndMapped};
enum class PartOf : uint32_t { Whole, Specular, Rough };

inline Bsdf part_of(const Bsdf& bsdf, PartOf part) {
    return part == PartOf::Whole      ? bsdf
           : part == PartOf::Specular ? bsdf.specular_part(kThreshold)
                                      : bsdf.rough_part(kThreshold);
}

/// One triangle in the xy plane, its front towards +z.
inline Scene triangle_scene(const Material& material, Normals normals) {
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.uv[0] = {{0, 1}, {1, 1}, {0, 0}};
    mesh.triangles = {{0, 1, 2}};
    if (normals == Normals::Leaning || normals == Normals::LeaningAndMapped)
        mesh.normals = {glm::normalize(vec3(0.5f, 0, 1)), glm::normalize(vec3(0.6f, 0.3f, 1)),
                        glm::normalize(vec3(0.3f, -0.2f, 1))};
    Scene scene;
    scene.meshes = {mesh};
    scene.instances = {Instance{}};
    scene.materials = {material};
    if (normals == Normals::Mapped || normals == Normals::LeaningAndMapped) {
        Texture texture;
        texture.size = {1, 1};
        texture.texels = {u8vec4(60, 150, 220, 255)};
        scene.textures = {texture};
        scene.materials[0].normal_texture.texture = 0;
    }
    return scene;
}

inline const Hit kHit{.t = 1, .instance = 0, .triangle = 0, .u = 0.25f, .v = 0.5f};

struct Case {
    const char* name;
    Material material;
    PartOf part = PartOf::Whole;
    float outside_ior = 1;  // of what the surface lies in
};

inline std::vector<Case> cases() {
    const auto make = [](const char* name, float metallic, float roughness, float transmission, bool solid) {
        Material m;
        m.base_color = Rgb(0.8f, 0.5f, 0.2f);
        m.metallic = metallic, m.roughness = roughness, m.transmission = transmission, m.solid = solid;
        return Case{name, m};
    };
    std::vector<Case> list = {
        make("Lambert", 0, 1, 0, false),          make("coated diffuse", 0, 0.4f, 0, false),
        make("metal", 1, 0.5f, 0, false),         make("thin sheet", 0, 0.5f, 0.8f, false),
        make("glass", 0, 0.6f, 1, true),          make("half glass, half metal", 0.5f, 0.4f, 0.7f, true),
        make("rough part", 0, 0.15f, 0, false),   make("specular part", 0.5f, 0.2f, 0, false),
        make("glass in glass", 0, 0.5f, 1, true),
    };
    list[0].material.specular = 0;
    list[6].part = PartOf::Rough;
    list[7].part = PartOf::Specular;
    list[8].outside_ior = 1.8f;
    return list;
}

/// Light from five directions, two of them grazing (one from below the leaning normals' plane) and one from behind.
inline const vec3 kLights[] = {glm::normalize(vec3(0.3f, 0.2f, 1)), glm::normalize(vec3(1, 0.1f, 0.2f)),
                               glm::normalize(vec3(-1, 0.1f, 0.2f)), glm::normalize(vec3(-0.5f, 0.5f, 0.7f)),
                               glm::normalize(vec3(0.2f, 0.4f, -1))};

}  // namespace photond::test
