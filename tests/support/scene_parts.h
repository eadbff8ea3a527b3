#pragma once
// Scenes put together piece by piece within a test.

#include <utility>

#include "renderer/scene/mesh_builder.h"  // glm::rotate
#include "renderer/scene/scene.h"

namespace photond::test {

/// Adds a mesh of its own material, placed once.
inline void add(Scene& scene, Mesh mesh, const Material& material) {
    mesh.material = static_cast<uint32_t>(scene.materials.size());
    scene.materials.push_back(material);
    Instance instance;
    instance.mesh = static_cast<uint32_t>(scene.meshes.size());
    scene.meshes.push_back(std::move(mesh));
    scene.instances.push_back(instance);
}

/// A plain Lambert reflector, the same in all channels, that may emit [W m^-2 sr^-1].
inline Material lambert(float albedo, float emission = 0) {
    Material m;
    m.base_color = Rgb(albedo);
    m.metallic = 0;
    m.specular = 0;
    m.emission = Rgb(emission);
    return m;
}

/// Black but for its own light [W m^-2 sr^-1].
inline Material emitting(const Rgb& radiance, bool two_sided = false) {
    Material material;
    material.base_color = Rgb(0);
    material.emission = radiance;
    material.double_sided = two_sided;
    return material;
}

/// Turned about a skew axis: where normals lie along axes, the sign of a zero decides between two tangent frames.
inline Scene turned(Scene scene) {
    const mat3 turn(glm::rotate(mat4(1.0f), 0.7f, glm::normalize(vec3(1, 2, 3))));
    for (Mesh& mesh : scene.meshes) {
        for (vec3& p : mesh.positions) p = turn * p;
        for (vec3& n : mesh.normals) n = turn * n;
    }
    for (Camera& camera : scene.cameras)
        for (vec3* v : {&camera.position, &camera.right, &camera.up, &camera.forward}) *v = turn * *v;
    for (PunctualLight& light : scene.punctual_lights)
        for (vec3* v : {&light.position, &light.direction}) *v = turn * *v;
    finish_scene(scene);
    return scene;
}

}  // namespace photond::test
