#pragma once
// Surfaces of all kinds in the open, under an environment.

#include "renderer/scene/mesh_builder.h"
#include "tests/support/environments.h"
#include "tests/support/scene_parts.h"

namespace photond::test {

inline Material coated(const Rgb& base_color, float roughness, float metallic = 0) {
    Material material;
    material.base_color = base_color;
    material.roughness = roughness;
    material.metallic = metallic;
    return material;
}

/// Above the origin; seen by no camera here.
inline void add_lamp(Scene& scene) {
    MeshBuilder lamp;
    lamp.quad({-1, 5, -1}, {1, 5, -1}, {1, 5, 1}, {-1, 5, 1});
    add(scene, lamp.build(0), emitting(Rgb(40)));
    finish_scene(scene);
}

/// A floor alone, seen at an angle: nothing stands before the environment.
inline Scene floor_under(const Material& material, Environment environment) {
    Scene scene;
    MeshBuilder floor;
    floor.quad({-50, 0, 50}, {50, 0, 50}, {50, 0, -50}, {-50, 0, -50});
    add(scene, floor.build(0), material);
    scene.cameras.push_back(look_at_camera({0, 1, 3}, {0, 0, 0}, {0, 1, 0}, 0.5f));
    scene.environment = std::move(environment);
    finish_scene(scene);
    return scene;
}

/// A ball of each kind in two rows above a floor; a point light above them.
inline Scene balls_under(Environment environment) {
    Material sheet = coated(Rgb(0.9f, 0.6f, 0.3f), 0.3f), frosted = coated(Rgb(1), 0.3f), glass = coated(Rgb(1), 0);
    sheet.transmission = frosted.transmission = glass.transmission = 1;
    frosted.solid = glass.solid = true;
    const Material kinds[] = {lambert(0.6f),
                              coated(Rgb(0.7f, 0.3f, 0.2f), 0.4f),
                              coated(Rgb(0.2f, 0.3f, 0.7f), 0),
                              coated(Rgb(1, 0.8f, 0.4f), 0.15f, 1),
                              coated(Rgb(1, 0.8f, 0.4f), 0.6f, 1),
                              coated(Rgb(0.9f), 0, 1),
                              sheet,
                              frosted,
                              glass,
                              coated(Rgb(0.8f), 0.03f, 1)};
    Scene scene;
    MeshBuilder floor;
    floor.quad({-6, 0, 6}, {6, 0, 6}, {6, 0, -6}, {-6, 0, -6});
    add(scene, floor.build(0), coated(Rgb(0.5f), 0.5f));
    for (size_t i = 0; i < std::size(kinds); ++i) {
        MeshBuilder ball;
        ball.sphere({1.2f * static_cast<float>(i % 5) - 2.4f, i < 5 ? 0.6f : 1.8f, i < 5 ? 0.6f : -0.6f}, 0.5f, 24);
        add(scene, ball.build(0), kinds[i]);
    }
    PunctualLight light;
    light.kind = PunctualLight::Kind::Point;
    light.position = {1, 5, 2};
    light.intensity = Rgb(20);
    scene.punctual_lights.push_back(light);
    scene.cameras.push_back(look_at_camera({0, 2.6f, 7}, {0, 1.1f, 0}, {0, 1, 0}, 0.6f));
    scene.environment = std::move(environment);
    finish_scene(scene);
    return scene;
}

}  // namespace photond::test
