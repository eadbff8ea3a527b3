// "glass": "solid" on surfaces as programs write them: seams with vertices twice, poles of many vertices, all rounded.

#include "renderer/scene/solid_glass.h"

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/scene/mesh_builder.h"
#include "renderer/scene/pose.h"
#include "tests/support/animated_gltf.h"

namespace photond::solid_glass_test {
namespace {

constexpr uint32_t kSegments = 48, kRings = 24;

/// A sphere as modelling programs write it: a grid over longitude and latitude whose last column lies on its first and
/// whose first and last rows are poles, each place by its own sine and cosine, and with triangles of next to no area at
/// the poles.
Mesh uv_sphere(const vec3& centre, float radius, uint32_t rings = kRings) {
    Mesh mesh;
    for (uint32_t r = 0; r <= rings; ++r)
        for (uint32_t s = 0; s <= kSegments; ++s) {
            const float theta = kPi * static_cast<float>(r) / static_cast<float>(kRings);
            const float phi = 2 * kPi * static_cast<float>(s) / static_cast<float>(kSegments);
            mesh.positions.push_back(centre + radius * vec3(std::sin(theta) * std::cos(phi), std::cos(theta),
                                                            -std::sin(theta) * std::sin(phi)));
        }
    for (uint32_t r = 0; r < rings; ++r)
        for (uint32_t s = 0; s < kSegments; ++s) {
            const uint32_t a = r * (kSegments + 1) + s, b = a + 1, c = a + kSegments + 1, d = c + 1;
            mesh.triangles.emplace_back(a, c, d);
            mesh.triangles.emplace_back(a, d, b);
        }
    return mesh;
}

Scene scene_of(std::vector<Mesh> meshes) {
    Scene scene;
    scene.materials.resize(1);
    scene.materials[0].name = "clear";
    scene.materials[0].transmission = 1, scene.materials[0].metallic = 0;
    scene.meshes = std::move(meshes);
    scene.instances.resize(scene.meshes.size());
    for (uint32_t i = 0; i < scene.instances.size(); ++i) scene.instances[i].mesh = i;
    finish_scene(scene);
    return scene;
}

bool fills(const Mesh& mesh) {
    Scene scene = scene_of({mesh});
    const bool filled = make_closed_glass_solid(scene) == 1;
    EXPECT_EQ(scene.warnings.empty(), filled);
    EXPECT_EQ(scene.needs.solid_glass, filled);
    return filled;
}

TEST(SolidGlass, SpheresOfLongitudeAndLatitudeAreClosed) {
    // Of the seam's edges and the poles' hardly one has its twin at equal positions.
    const Mesh sphere = uv_sphere(vec3(0), 1);
    EXPECT_NE(sphere.positions[kSegments + 1], sphere.positions[2 * kSegments + 1]);
    EXPECT_NE(sphere.positions[kRings * (kSegments + 1)], sphere.positions.back());
    EXPECT_TRUE(fills(sphere));
}

TEST(SolidGlass, SizeAndPlaceDoNotMatter) {
    for (const float radius : {1e-4f, 1.0f, 1e4f})
        for (const float away : {0.0f, 10.0f, 1000.0f}) {
            EXPECT_TRUE(fills(uv_sphere(radius * away * vec3(1, -0.3f, 0.7f), radius))) << radius << ' ' << away;
            EXPECT_FALSE(fills(uv_sphere(radius * away * vec3(1, -0.3f, 0.7f), radius, kRings - 1))) << radius;
        }
}

TEST(SolidGlass, InstancesOfAScaledMeshAreFilledWithIt) {
    Scene scene = scene_of({uv_sphere(vec3(0), 1)});
    for (const vec3& scale : {vec3(1e-3f), vec3(5, 1e-2f, 30), vec3(-2, 1, 1)}) {
        Instance instance;
        instance.identity = false;
        instance.to_world = mat4x3(vec3(scale.x, 0, 0), vec3(0, scale.y, 0), vec3(0, 0, scale.z), vec3(3));
        scene.instances.push_back(instance);
    }
    EXPECT_EQ(make_closed_glass_solid(scene), 1u);
    for (const Instance& instance : scene.instances)
        EXPECT_TRUE(scene.materials[scene.meshes[instance.mesh].material].solid);
}

TEST(SolidGlass, VerticesOfOtherMeshesDoNotCount) {
    // Primitives of a file often share one list of vertices; one of another's far away must not widen the welding.
    Mesh bowl = uv_sphere(vec3(0), 1, kRings - 1);
    bowl.positions.emplace_back(1e7f, 0, 0);
    EXPECT_FALSE(fills(bowl));
}

TEST(SolidGlass, AFinelyMeshedRimIsNoSeam) {
    // A tube whose ends have vertices nearer than the welding distance: welded in chains they would be its caps.
    std::vector<Mesh> meshes(1);
    Mesh& tube = meshes[0];
    constexpr uint32_t kSides = 4000;
    constexpr float kThin = 2e-4f;  // 20 welding distances; a side is a thirtieth of one
    for (uint32_t s = 0; s < kSides; ++s)
        for (const float height : {-1.0f, 1.0f}) {
            const float phi = 2 * kPi * static_cast<float>(s) / static_cast<float>(kSides);
            tube.positions.emplace_back(kThin * std::cos(phi), height, -kThin * std::sin(phi));
        }
    for (uint32_t s = 0; s < kSides; ++s) {
        const uint32_t a = 2 * s, b = 2 * ((s + 1) % kSides);
        tube.triangles.emplace_back(a, b, a + 1);
        tube.triangles.emplace_back(b, b + 1, a + 1);
    }
    Scene scene = scene_of(std::move(meshes));
    EXPECT_EQ(make_closed_glass_solid(scene), 0u);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_NE(scene.warnings[0].find(std::to_string(2 * kSides) + " open edges"), std::string::npos)
        << scene.warnings[0];
}

TEST(SolidGlass, WhatStaysOpenIsSaidWithTheNumberOfEdges) {
    Mesh holed = uv_sphere(vec3(0), 1);
    holed.triangles.erase(holed.triangles.begin() + kSegments * kRings);  // one triangle at the equator
    Scene scene = scene_of({uv_sphere(vec3(0), 1), holed, uv_sphere(vec3(5), 2, kRings - 1)});
    EXPECT_EQ(make_closed_glass_solid(scene), 1u);
    EXPECT_EQ(scene.warnings, std::vector<std::string>(
                                  {"\"glass\": \"solid\" leaves thin sheets of the material \"clear\", whose surface "
                                   "is not closed: " +
                                   std::to_string(3 + kSegments) + " open edges in 2 of its meshes"}));
}

// --- animated --------------------------------------------------------------------------------------------------------
const Material& material_of(const Scene& scene, size_t mesh) { return scene.materials[scene.meshes[mesh].material]; }

Scene filled(const char* file) {
    Scene scene = test::animated_file(file).load();
    EXPECT_EQ(make_closed_glass_solid(scene), 2u);
    finish_scene(scene);
    return scene;
}

TEST(SolidGlass, AnimatedMaterialsOfSolidsMove) {
    Scene scene = filled("SheetsThatChangeColour");
    EXPECT_EQ(material_of(scene, 0).base_color, Rgb(1));
    EXPECT_TRUE(pose_scene(scene, {0, 0.25}).materials);
    EXPECT_EQ(material_of(scene, 0).base_color, Rgb(0.25f));
    EXPECT_TRUE(material_of(scene, 0).solid);
    EXPECT_EQ(material_of(scene, 0).transmission, 1);
}

TEST(SolidGlass, WhatBecomesGlassIsFilledToo) {
    Scene scene = filled("SheetsThatAppear");
    const auto apart = scene.meshes[1].positions;
    EXPECT_FALSE(scene.needs.solid_glass);
    pose_scene(scene, {0, 1});
    EXPECT_TRUE(scene.needs.solid_glass);
    EXPECT_EQ(material_of(scene, 1).transmission, 1);
    EXPECT_NE(scene.meshes[1].positions, apart) << "it touches the other one";
    pose_scene(scene, {0, 2});
    EXPECT_EQ(scene.meshes[1].positions, apart);
}

TEST(SolidGlass, AClosedMeshThatIsFlatAtRestIsFilled) {
    TestGltf file = test::animated_file("SheetsThatAppear");
    file.set("nodes", R"([{"mesh":0},{"mesh":0,"scale":[0,0,0]}])");
    Scene scene = file.load();
    EXPECT_EQ(make_closed_glass_solid(scene), 2u);
}

}  // namespace
}  // namespace photond::solid_glass_test
