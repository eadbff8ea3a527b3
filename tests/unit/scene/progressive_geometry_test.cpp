// The shapes of the scenes of the papers on progressive photon mapping: small, of clear glass and mirrors, and nothing
// touches or cuts the glass, so that a path always knows whether it is inside.

#include <gtest/gtest.h>

#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/scene.h"
#include "renderer/scene/touching_solids.h"
#include "tests/support/rays.h"

namespace photond::progressive_geometry_test {
namespace {

/// Those of the scene's meshes that are solid glass, or the others.
Scene part_of(Scene scene, bool glass) {
    std::erase_if(scene.instances, [&](const Instance& instance) {
        return scene.materials[scene.meshes[instance.mesh].material].solid != glass;
    });
    return scene;
}

/// How many edges of one scene's triangles, each 0.1 mm longer at both ends, meet a triangle of the other's.
size_t count_cuts(const Scene& edges, const Scene& surfaces) {
    constexpr float kClearance_m = 1e-4f;
    const auto intersector = test::intersector_of(surfaces);
    size_t cuts = 0;
    for (uint32_t i = 0; i < edges.instances.size(); ++i)
        for (uint32_t t = 0; t < edges.meshes[edges.instances[i].mesh].triangles.size(); ++t) {
            const TriangleCorners corners = world_triangle(edges, i, t);
            for (int k = 0; k < 3; ++k) {
                const vec3 side = corners.p[(k + 1) % 3] - corners.p[k];
                const float length = glm::length(side);
                const vec3 along = side / length;
                const Ray ray{corners.p[k] - kClearance_m * along, along, length + 2 * kClearance_m};
                cuts += intersector->closest_hit(ray).valid();
            }
        }
    return cuts;
}

size_t count_cuts_of_glass(const Scene& glass, const Scene& rest) {
    return count_cuts(glass, rest) + count_cuts(rest, glass);
}

TEST(ProgressiveScenes, AreSmallAndOfGlass) {
    EXPECT_EQ(builtin_scene_names("progressive").size(), 6u);
    for (const std::string_view name : builtin_scene_names("progressive")) {
        Scene scene = make_builtin_scene(name);
        EXPECT_LT(scene.triangle_count, 20'000u) << name;
        EXPECT_TRUE(scene.needs.delta && scene.needs.solid_glass && scene.needs.diffuse) << name;
        EXPECT_TRUE(scene.warnings.empty()) << name;
        EXPECT_EQ(overlap_touching_solids(scene), 0u) << name;
        EXPECT_NE(scene.needs.area_lights, scene.needs.punctual_lights) << name << " has one light";
    }
}

TEST(ProgressiveScenes, NothingTouchesTheGlass) {
    for (const std::string_view name : builtin_scene_names("progressive")) {
        const Scene scene = make_builtin_scene(name);
        Scene glass = part_of(scene, true);
        const Scene rest = part_of(scene, false);
        ASSERT_FALSE(glass.instances.empty() || rest.instances.empty()) << name;
        EXPECT_EQ(count_cuts_of_glass(glass, rest), 0u) << name;
        for (const Instance& instance : glass.instances)
            for (vec3& position : glass.meshes[instance.mesh].positions) position.y -= 0.01f;
        EXPECT_GT(count_cuts_of_glass(glass, rest), 0u) << name << ": lowered, it must be seen to cut";
    }
}

}  // namespace
}  // namespace photond::progressive_geometry_test
