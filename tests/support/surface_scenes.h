#pragma once
// Scenes that are nothing but surfaces, and the kernels that masses on them are asked for with.

#include <string>

#include "renderer/core/rng.h"
#include "renderer/photons/kernel.h"
#include "renderer/scene/mesh_builder.h"

namespace photond::test {

inline const std::vector<Kernel> kKernels = {Kernel(KernelShape::Constant), Kernel(KernelShape::Cone, 1.0f),
                                             Kernel(KernelShape::Cone, 1.7f), Kernel(KernelShape::Gaussian),
                                             Kernel(KernelShape::Epanechnikov)};
inline const vec3 kUp(0, 1, 0);

inline std::string name_of(const Kernel& kernel) {
    return "kernel " + std::to_string(static_cast<int>(kernel.shape())) + ", k = " + std::to_string(kernel.cone_k());
}

inline Scene scene_of(std::vector<Mesh> meshes) {
    Scene scene;
    for (Mesh& mesh : meshes) {
        Instance instance;
        instance.mesh = static_cast<uint32_t>(scene.meshes.size());
        scene.meshes.push_back(std::move(mesh));
        scene.instances.push_back(instance);
    }
    scene.materials.emplace_back();
    finish_scene(scene);
    return scene;
}

/// A rectangle of the plane y = `height`, its front upwards.
inline MeshBuilder& add_floor(MeshBuilder& builder, vec2 min, vec2 max, float height = 0) {
    return builder.quad({min.x, height, max.y}, {max.x, height, max.y}, {max.x, height, min.y}, {min.x, height, min.y});
}
inline Mesh floor_mesh(vec2 min, vec2 max, float height = 0) {
    MeshBuilder builder;
    return add_floor(builder, min, max, height).build(0);
}

/// Boxes of 12 x 2 x 12 mm, thrown into a cylinder: 24 edges each.
inline Mesh chips(int count, float radius_m, float height_m) {
    MeshBuilder builder;
    RandomStream random(5, RandomDomain::Test, 0, 0);
    for (int i = 0; i < count; ++i) {
        const float reach = radius_m * std::sqrt(random.next()), angle = 2 * kPi * random.next();
        const vec3 centre(reach * std::cos(angle), 0.01f + height_m * random.next(), reach * std::sin(angle));
        const vec3 axis(random.next() - 0.5f, random.next() - 0.5f, random.next() - 0.5f);
        builder.place(glm::rotate(glm::translate(mat4(1), centre), 2 * kPi * random.next(), glm::normalize(axis)));
        builder.box({-0.006f, -0.001f, -0.006f}, {0.006f, 0.001f, 0.006f});
    }
    return builder.build(0);
}

/// A floor of 4 x 4 m with a heap of 24,000 edges in the middle, all within a disc of 16 cm.
inline Scene heap_on_a_floor() { return scene_of({floor_mesh({-2, -2}, {2, 2}), chips(1000, 0.14f, 0.06f)}); }

}  // namespace photond::test
