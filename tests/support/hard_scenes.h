#pragma once
// Scenes that leave a method nothing to work with: no light, nothing that reflects, mirrors alone, nothing at all.

#include <string_view>
#include <vector>

#include "renderer/scene/mesh_builder.h"
#include "tests/support/scene_parts.h"

namespace photond::test {

/// A floor and a wall, seen from the front; no light. Not finished (finish_scene).
inline Scene corner(const Material& material) {
    Scene scene;
    scene.materials = {material};
    scene.meshes = {MeshBuilder().quad({-2, -1, 0}, {2, -1, 0}, {2, -1, -4}, {-2, -1, -4}).build(0),
                    MeshBuilder().quad({-2, -1, -4}, {2, -1, -4}, {2, 3, -4}, {-2, 3, -4}).build(0)};
    scene.instances.resize(2);
    scene.instances[1].mesh = 1;
    scene.cameras = {Camera{}};
    return scene;
}
inline PunctualLight lamp() {
    PunctualLight light;
    light.position = vec3(0, 2, -2);
    return light;
}
inline void add_sky(Scene& scene) {
    Environment sky;
    sky.map.size = {8, 4};
    sky.map.radiance.assign(32, Rgb(1));
    scene.environment = sky;
}

struct HardScene {
    const char* name;
    Scene scene;
    bool dark;  // nothing is to be seen
};
inline std::vector<HardScene> hard_scenes() {
    Material mirror;
    mirror.metallic = 1;
    mirror.roughness = 0;
    std::vector<HardScene> scenes;
    scenes.push_back({"no light", corner(lambert(0.5f)), true});
    scenes.push_back({"a light without power", corner(lambert(0.5f)), true});
    scenes.back().scene.punctual_lights = {lamp()};
    scenes.back().scene.punctual_lights[0].intensity = Rgb(0);
    scenes.push_back({"black", corner(lambert(0)), true});
    scenes.back().scene.punctual_lights = {lamp()};
    scenes.push_back({"all mirrors", corner(mirror), true});
    scenes.back().scene.punctual_lights = {lamp()};
    scenes.push_back({"mirrors under the sky", corner(mirror), false});
    add_sky(scenes.back().scene);
    scenes.push_back({"nothing but the sky", Scene{}, false});
    scenes.back().scene.cameras = {Camera{}};
    add_sky(scenes.back().scene);
    scenes.push_back({"nothing at all", Scene{}, true});
    scenes.back().scene.cameras = {Camera{}};
    scenes.push_back({"lamp", corner(lambert(1)), false});
    scenes.back().scene.punctual_lights = {lamp()};
    for (HardScene& hard : scenes) finish_scene(hard.scene);
    return scenes;
}

/// What GPU tests try of them: no light, nothing at all, and a sky above mirrors and above walls. The walls are
/// rendered by the shaders that mirrors need, which are compiled once then.
inline std::vector<HardScene> hard_scenes_of_devices() {
    std::vector<HardScene> scenes;
    for (HardScene& hard : hard_scenes())
        for (const std::string_view name : {"no light", "mirrors under the sky", "nothing at all"})
            if (hard.name == name) scenes.push_back(std::move(hard));
    scenes.push_back({"walls under the sky", corner(lambert(0.5f)), false});
    add_sky(scenes.back().scene);
    finish_scene(scenes.back().scene);
    scenes.back().scene.needs.delta = true;
    return scenes;
}

}  // namespace photond::test
