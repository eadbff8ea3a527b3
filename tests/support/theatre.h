#pragma once
// A room in which much moves, each thing in its own way, about what stands still.

#include "renderer/scene/rig_builder.h"
#include "renderer/scene/scene.h"
#include "tests/support/scene_parts.h"

namespace photond::test {

inline constexpr float kTheatreLeft = -6;  // where what leaves the room ends

/// What moves: a sphere that turns as it flies over the torus, one that shrinks to nothing, one that jumps, one that
/// leaves the room, one whose material lets light pass for a time, one that swells, and one that two joints bend.
inline Scene make_theatre() {
    Scene scene;
    add(scene, MeshBuilder().box(vec3(-2), vec3(2)).build(0), lambert(0.5f));
    add(scene, MeshBuilder().torus(vec3(0), 0.9f, 0.3f, 64, 32).build(0), lambert(0.5f));
    Rig rig;
    Animation animation;
    const auto make_sphere = [&](float radius) {
        auto object = std::make_shared<ObjectMesh>();
        object->mesh = make_icosphere(2, static_cast<uint32_t>(scene.materials.size()));
        for (vec3& p : object->mesh.positions) p = radius * p;
        scene.materials.push_back(lambert(0.5f));
        return object;
    };
    const auto add_sphere = [&](float radius, const vec3& at) {
        const uint32_t node = add_node(rig, {.translation = dvec3(at)});
        add_rigged_mesh(scene, rig, make_sphere(radius), node);
        return node;
    };
    const uint32_t flying = add_sphere(0.5f, vec3(0)), shrinking = add_sphere(0.6f, vec3(1, 1, 0)),
                   jumping = add_sphere(0.4f, vec3(0)), leaving = add_sphere(0.3f, vec3(0));
    add_sphere(0.5f, vec3(-1, 0.5f, 0.2f));
    const auto material = static_cast<uint32_t>(scene.materials.size()) - 1;
    scene.materials[material].alpha_mode = AlphaMode::Mask;
    scene.materials[material].alpha = 0.6f;
    rig.materials.push_back({.material = material, .rest = scene.materials[material]});
    const uint32_t swelling = add_sphere(1, vec3(0.5f, -0.5f, 0.5f));

    const uint32_t foot = add_node(rig, {}), head = add_node(rig, {});
    const std::shared_ptr<ObjectMesh> bent = make_sphere(0.7f);
    bent->joint_sets = 1;
    for (const vec3& p : bent->mesh.positions) {
        const float share = glm::clamp(0.5f + p.y, 0.0f, 1.0f);
        bent->influences.insert(bent->influences.end(), {{0, 1 - share}, {1, share}, {}, {}});
    }
    rig.skins.push_back({.joints = {foot, head}, .inverse_bind = {dmat4(1), dmat4(1)}});
    add_rigged_mesh(scene, rig, bent, foot, 0);

    animation.channels = {
        drive(Property::Translation, flying, {0, 1}, {-1, -1, -1, 1, 0.5f, 1}),
        drive(Property::Rotation, flying, {0, 1}, keys_of({turn_about({0, 1, 0}, 0), turn_about({0, 1, 0}, 2)})),
        drive(Property::Scale, shrinking, {0, 0.5f, 1}, {1, 1, 1, 0, 0, 0, 1, 1, 1}),
        drive(Property::Translation, jumping, {0, 0.3f, 0.7f}, {1, -1, 0, -1, 1, 1, 0, 0, -1.5f}, Interpolation::Step),
        drive(Property::Translation, leaving, {0, 1}, {0, 0, 1, kTheatreLeft, 0, 1}),
        drive(Property::AlphaCutoff, 0, {0, 0.4f, 0.8f}, {0.5f, 0.7f, 0.5f}, Interpolation::Step),
        drive(Property::Scale, swelling, {0, 1}, {0.1f, 0.1f, 0.1f, 1.4f, 1.4f, 1.4f}),
        drive(Property::Rotation, head, {0, 1}, keys_of({turn_about({0, 0, 1}, 0), turn_about({0, 0, 1}, 1.5)}))};
    rig.animations.push_back(std::move(animation));
    adopt_rig(scene, std::make_shared<const Rig>(std::move(rig)));
    finish_scene(scene);
    return scene;
}

/// A lamp, a sphere, that swells until it takes many more voxels than the torus that stands still; two corners keep the
/// bounds where they are.
inline Scene make_swelling_lamp() {
    Scene scene;
    add(scene, MeshBuilder().box(vec3(-2), vec3(-1.9f)).box(vec3(1.9f), vec3(2)).build(0), lambert(0.5f));
    Mesh torus = MeshBuilder().torus(vec3(0), 0.4f, 0.1f, 64, 32).build(0);
    torus.normals.clear();  // flat, like the other moving rooms: their pipelines are compiled once
    add(scene, std::move(torus), lambert(0.5f));
    Rig rig;
    auto sphere = std::make_shared<ObjectMesh>();
    sphere->mesh = make_icosphere(2, static_cast<uint32_t>(scene.materials.size()));
    sphere->mesh.normals.clear();
    scene.materials.push_back(lambert(0.5f));
    scene.materials.back().emission = Rgb(1);
    const uint32_t node = add_node(rig, {});
    add_rigged_mesh(scene, rig, sphere, node);
    Animation animation;
    animation.channels = {drive(Property::Scale, node, {0, 1}, {0.1f, 0.1f, 0.1f, 1.5f, 1.5f, 1.5f})};
    rig.animations.push_back(std::move(animation));
    adopt_rig(scene, std::make_shared<const Rig>(std::move(rig)));
    finish_scene(scene);
    return scene;
}

}  // namespace photond::test
