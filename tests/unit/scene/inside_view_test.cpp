// Closed rooms without a camera: looked at from within, where their lamps' light is.

#include "renderer/scene/inside_view.h"

#include <gtest/gtest.h>

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/mesh_builder.h"
#include "tests/support/scene_parts.h"

namespace photond::inside_view_test {
namespace {

const vec3 kLow(-3, 0, -2), kHigh(3, 2.5f, 4);
enum class Ceiling : bool { No, Yes };

/// A room with a table, and with a lamp under the ceiling or where that would be.
Scene make_room(Ceiling ceiling, float lamp_w = 10) {
    Scene scene;
    MeshBuilder walls;
    const vec3 a = kLow, b = kHigh;
    walls.quad({a.x, a.y, b.z}, {b.x, a.y, b.z}, {b.x, a.y, a.z}, {a.x, a.y, a.z});
    walls.quad({a.x, a.y, a.z}, {b.x, a.y, a.z}, {b.x, b.y, a.z}, {a.x, b.y, a.z});
    walls.quad({b.x, a.y, b.z}, {a.x, a.y, b.z}, {a.x, b.y, b.z}, {b.x, b.y, b.z});
    walls.quad({a.x, a.y, b.z}, {a.x, a.y, a.z}, {a.x, b.y, a.z}, {a.x, b.y, b.z});
    walls.quad({b.x, a.y, a.z}, {b.x, a.y, b.z}, {b.x, b.y, b.z}, {b.x, b.y, a.z});
    if (ceiling == Ceiling::Yes) walls.quad({a.x, b.y, a.z}, {b.x, b.y, a.z}, {b.x, b.y, b.z}, {a.x, b.y, b.z});
    test::add(scene, walls.build(0), test::lambert(0.5f));
    test::add(scene, MeshBuilder().box({-0.8f, 0, 0.4f}, {0.8f, 0.8f, 1.6f}).build(0), test::lambert(0.5f));
    Material lamp = test::lambert(0);
    lamp.emission = Rgb(lamp_w);
    test::add(
        scene,
        MeshBuilder().quad({-0.3f, 2.4f, 0.7f}, {0.3f, 2.4f, 0.7f}, {0.3f, 2.4f, 1.3f}, {-0.3f, 2.4f, 1.3f}).build(0),
        lamp);
    return scene;
}

bool is_within(const vec3& p) { return glm::all(glm::greaterThan(p, kLow)) && glm::all(glm::lessThan(p, kHigh)); }

TEST(InsideView, IsOfAClosedRoom) {
    Scene scene = make_room(Ceiling::Yes);
    finish_scene(scene);
    const Camera camera = find_camera(scene, "");
    ASSERT_TRUE(scene.inside_view);
    EXPECT_EQ(camera.name, "framed");
    EXPECT_TRUE(is_within(camera.position))
        << camera.position.x << ' ' << camera.position.y << ' ' << camera.position.z;
    // Far back, and with something of the room before it.
    MemoryBudget budget;
    Stats stats;
    const auto rays = make_embree_intersector(scene, budget, stats);
    EXPECT_GT(rays->closest_hit({camera.position, camera.forward}).t, 3);
    EXPECT_FALSE(rays->occluded({camera.position, 0.99f * (vec3(0, 2.4f, 1) - camera.position), 1}))
        << "it sees the lamp";
}

TEST(InsideView, IsNoneWhereLightLeavesOrComesFromWithoutOrIsNone) {
    Scene open = make_room(Ceiling::No), dark = make_room(Ceiling::Yes, 0), sunny = make_room(Ceiling::Yes),
          glazed = make_room(Ceiling::Yes), watched = make_room(Ceiling::Yes);
    sunny.punctual_lights.push_back({.kind = PunctualLight::Kind::Directional});
    glazed.materials.front().transmission = 1;
    watched.cameras.push_back(look_at_camera(dvec3(0, 9, 9), dvec3(0), dvec3(0, 1, 0), 1));
    for (Scene* scene : {&open, &dark, &sunny, &glazed, &watched}) {
        finish_scene(*scene);
        EXPECT_FALSE(scene->inside_view);
        EXPECT_FALSE(is_within(find_camera(*scene, "").position));
    }
}

TEST(InsideView, IsOfAPointLightTooAndTheSameEachTime) {
    Scene scene = make_room(Ceiling::Yes, 0);
    scene.punctual_lights.push_back({.kind = PunctualLight::Kind::Point, .position = vec3(1, 2, 3)});
    finish_scene(scene);
    ASSERT_TRUE(scene.inside_view);
    EXPECT_TRUE(is_within(scene.inside_view->position));
    EXPECT_EQ(find_inside_view(scene)->position, scene.inside_view->position);
}

}  // namespace
}  // namespace photond::inside_view_test
