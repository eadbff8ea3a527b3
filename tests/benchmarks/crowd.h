#pragma once
// What benches of moving scenes show: 200,000 triangles of which a tenth moves.

#include <random>

#include "renderer/scene/mesh_builder.h"
#include "renderer/scene/rig_builder.h"

namespace photond::test {

/// Spheres of 1,280 triangles in a box: still ones, and those that fly among them and turn. One shines, and has 320.
inline Scene make_crowd() {
    constexpr uint32_t kStill = 141, kMoving = 16;
    Scene scene;
    Material matte, lamp;
    matte.metallic = lamp.metallic = 0;
    lamp.emission = Rgb(20);
    scene.materials = {matte, lamp};
    std::mt19937 random(5);
    std::uniform_real_distribution<float> uniform(-1, 1);
    const auto place = [&] { return vec3(10 * uniform(random), 3 * uniform(random), 10 * uniform(random)); };
    MeshBuilder room;
    room.box({-12, -5, -12}, {12, 5, 12});
    scene.meshes.push_back(room.build(0));
    for (uint32_t i = 0; i < kStill; ++i) {
        const vec3 at = place();
        Mesh mesh = make_icosphere(3, 0);
        for (vec3& p : mesh.positions) p = at + 0.5f * p;
        scene.meshes.push_back(std::move(mesh));
    }
    for (uint32_t i = 0; i < scene.meshes.size(); ++i) scene.instances.push_back({.mesh = i});
    Rig rig;
    Animation animation;
    for (uint32_t i = 0; i < kMoving; ++i) {
        auto object = std::make_shared<ObjectMesh>();
        object->mesh = make_icosphere(i == 0 ? 2 : 3, i == 0 ? 1 : 0);
        const uint32_t node = add_node(rig, {});
        add_rigged_mesh(scene, rig, std::move(object), node);
        const vec3 from = place(), to = place();
        animation.channels.push_back(
            drive(Property::Translation, node, {0, 1}, {from.x, from.y, from.z, to.x, to.y, to.z}));
        animation.channels.push_back(
            drive(Property::Rotation, node, {0, 1}, keys_of({turn_about({0, 1, 0}, 0), turn_about({0, 1, 0}, 2)})));
    }
    rig.animations.push_back(std::move(animation));
    adopt_rig(scene, std::make_shared<const Rig>(std::move(rig)));
    finish_scene(scene);
    return scene;
}

}  // namespace photond::test
