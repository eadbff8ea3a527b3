// Light that glass and mirrors cast, where little else is to be seen.

#include "renderer/scene/builtin_families.h"
#include "renderer/scene/mesh_builder.h"

namespace photond {

/// A glass ball of 10 cm on a floor of 20 m under a small lamp: what casts light is far smaller than the scene.
Scene make_glass_on_floor() {
    constexpr float kRadius = 0.05f, kAbove = 0.005f;  // a little above the floor, so that no two surfaces touch
    Scene scene;
    const uint32_t grey = add_material(scene, lambert("floor", Rgb(0.5f)));
    const uint32_t clear = add_material(scene, glass("glass"));
    const uint32_t lamp = add_material(scene, emitter("lamp", Rgb(50)));
    add_mesh(scene, MeshBuilder().quad({-10, 0, 10}, {10, 0, 10}, {10, 0, -10}, {-10, 0, -10}).build(grey));
    add_mesh(scene, MeshBuilder().sphere({0, kRadius + kAbove, 0}, kRadius, 48).build(clear));
    add_mesh(scene,
             MeshBuilder().quad({-0.2f, 1, 0.2f}, {-0.2f, 1, -0.2f}, {0.2f, 1, -0.2f}, {0.2f, 1, 0.2f}).build(lamp));
    add_camera(scene, {0, 0.5, 0.8}, {0, 0.02, 0}, 0.7f);
    return scene;
}

}  // namespace photond
