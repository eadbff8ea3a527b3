#pragma once
// A glass sphere of 10 cm on a floor of 20 m under a small lamp: what casts light is far smaller than the scene.

#include "tests/support/scene_parts.h"

namespace photond::test {

inline constexpr float kGlassRadius_m = 0.05f;

inline Scene glass_on_floor() {
    Scene scene;
    add(scene, MeshBuilder().quad({-10, 0, 10}, {10, 0, 10}, {10, 0, -10}, {-10, 0, -10}).build(0), lambert(0.5f));
    Material glass;
    glass.metallic = glass.roughness = 0;
    glass.transmission = 1;
    glass.solid = true;
    // A little above the floor, so that no two surfaces touch.
    add(scene, MeshBuilder().sphere({0, kGlassRadius_m + 0.005f, 0}, kGlassRadius_m, 48).build(0), glass);
    add(scene, MeshBuilder().quad({-0.2f, 1, 0.2f}, {-0.2f, 1, -0.2f}, {0.2f, 1, -0.2f}, {0.2f, 1, 0.2f}).build(0),
        emitting(Rgb(50)));
    Camera camera;
    camera.position = vec3(0, 0.5f, 0.8f);
    camera.forward = glm::normalize(vec3(0, 0.02f, 0) - camera.position);
    camera.right = vec3(1, 0, 0);
    camera.up = glm::cross(camera.right, camera.forward);
    camera.yfov = 0.7f;
    scene.cameras = {camera};
    finish_scene(scene);
    return scene;
}

}  // namespace photond::test
