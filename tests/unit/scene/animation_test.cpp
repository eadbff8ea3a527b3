// Animated glTF: every trap of its specification that loaders fall into is a file here, posed at several times and
// compared with the equations, evaluated apart (tests/support/gltf_equations.h).

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "protocol/error.h"
#include "renderer/scene/pose.h"
#include "tests/support/animated_gltf.h"
#include "tests/support/gltf_equations.h"

namespace photond::animation_test {
namespace {

constexpr double kTimes[] = {-1, 0, 0.37, 1.21, 5};

class Traps : public testing::TestWithParam<test::AnimatedFile> {};

double size_of(const Scene& scene) { return 1e-30 + static_cast<double>(glm::length(scene.bounds.diagonal())); }

bool morphs(const Scene& scene, size_t mesh) {
    return std::ranges::any_of(scene.rig->meshes, [&](const RiggedMesh& rigged) {
        return rigged.mesh == mesh && !rigged.object->targets.empty();
    });
}

/// The scene's vertices are the evaluation's, mesh by mesh, and its fronts are on the normals' side.
void expect_equations(const Scene& scene, const test::EvaluatedScene& evaluated) {
    ASSERT_EQ(scene.meshes.size(), evaluated.primitives.size());
    for (size_t m = 0; m < scene.meshes.size(); ++m) {
        const Mesh& mesh = scene.meshes[m];
        const test::EvaluatedPrimitive& expected = evaluated.primitives[m];
        ASSERT_EQ(mesh.positions.size(), expected.positions.size());
        for (size_t v = 0; v < mesh.positions.size(); ++v)
            EXPECT_LE(glm::length(dvec3(mesh.positions[v]) - expected.positions[v]), 1e-6 * size_of(scene))
                << "vertex " << v << " of mesh " << m;
        ASSERT_EQ(mesh.normals.size(), expected.normals.size());
        for (size_t v = 0; v < mesh.normals.size(); ++v)
            EXPECT_LE(glm::length(dvec3(mesh.normals[v]) - expected.normals[v]), 1e-6)
                << "normal " << v << " of mesh " << m;
        for (const uvec3& t : mesh.triangles) {
            if (mesh.normals.empty() || morphs(scene, m)) break;  // targets may bend normals as they like
            const vec3 front =
                glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
            EXPECT_GT(glm::dot(front, mesh.normals[t.x] + mesh.normals[t.y] + mesh.normals[t.z]), 0)
                << "a triangle of mesh " << m << " shows its back";
        }
    }
    ASSERT_EQ(scene.cameras.size(), evaluated.cameras.size());
    for (size_t c = 0; c < scene.cameras.size(); ++c)
        EXPECT_LE(glm::length(dvec3(scene.cameras[c].position) - dvec3(evaluated.cameras[c][3])), 1e-6);
    ASSERT_EQ(scene.punctual_lights.size(), evaluated.lights.size());
    for (size_t l = 0; l < scene.punctual_lights.size(); ++l) {
        EXPECT_LE(glm::length(dvec3(scene.punctual_lights[l].position) - dvec3(evaluated.lights[l][3])), 1e-6);
        EXPECT_LE(
            glm::length(dvec3(scene.punctual_lights[l].direction) + glm::normalize(dvec3(evaluated.lights[l][2]))),
            1e-6);
    }
}

TEST_P(Traps, ArePosedAsTheEquationsSay) {
    const test::AnimatedFile& file = GetParam();
    Scene scene = file.gltf.load();
    expect_equations(scene, test::evaluate_gltf(file.gltf.json(), file.gltf.binary(), std::nullopt, 0));
    ASSERT_TRUE(scene.rig);
    for (uint32_t animation = 0; animation < scene.rig->animations.size(); ++animation)
        for (const double time : kTimes) {
            SCOPED_TRACE(std::string(file.name) + ", animation " + std::to_string(animation) + " at " +
                         std::to_string(time));
            pose_scene(scene, {animation, time});
            expect_equations(scene, test::evaluate_gltf(file.gltf.json(), file.gltf.binary(), animation, time));
        }
    pose_scene(scene, {});
    expect_equations(scene, test::evaluate_gltf(file.gltf.json(), file.gltf.binary(), std::nullopt, 0));
}

// What was shown before leaves nothing behind.
TEST_P(Traps, FollowFromTheMomentAlone) {
    const test::AnimatedFile& file = GetParam();
    Scene travelled = file.gltf.load();
    for (const double time : {2.0, 0.37, 0.5, 1.21, 0.37}) {
        pose_scene(travelled, {0, time});
        Scene fresh = file.gltf.load();
        pose_scene(fresh, {0, time});
        ASSERT_EQ(travelled.meshes.size(), fresh.meshes.size());
        for (size_t m = 0; m < fresh.meshes.size(); ++m) {
            EXPECT_EQ(travelled.meshes[m].positions, fresh.meshes[m].positions);
            EXPECT_EQ(travelled.meshes[m].normals, fresh.meshes[m].normals);
            EXPECT_EQ(travelled.meshes[m].triangles, fresh.meshes[m].triangles);
        }
        EXPECT_EQ(travelled.bounds.min, fresh.bounds.min);
        EXPECT_EQ(travelled.bounds.max, fresh.bounds.max);
        EXPECT_EQ(travelled.triangle_count, fresh.triangle_count);
    }
}

INSTANTIATE_TEST_SUITE_P(Files, Traps, testing::ValuesIn(test::animated_files()),
                         [](const auto& info) { return info.param.name; });

TEST(Animation, OnlyWhatMovesIsPosedAgain) {
    Scene scene = test::animated_file("ChildOfATurningParent").load();
    const SceneChange first = pose_scene(scene, {0, 0.5});
    EXPECT_EQ(first.moved.size(), 2u) << "the still mesh is the third";
    EXPECT_TRUE(first.reshaped.empty());
    EXPECT_FALSE(first.materials);
    EXPECT_TRUE(pose_scene(scene, {0, 0.5}).moved.empty());
    pose_scene(scene, {0, 7});
    EXPECT_TRUE(pose_scene(scene, {0, 8}).moved.empty()) << "after the last key nothing moves";
}

TEST(Animation, WhatIsScaledToNothingIsGoneForThatTime) {
    Scene scene = test::animated_file("ScaledThroughNothing").load();
    const uint64_t all = scene.triangle_count;
    EXPECT_EQ(pose_scene(scene, {0, 1}).reshaped.size(), 1u);
    EXPECT_EQ(scene.triangle_count, 0u);
    pose_scene(scene, {0, 1.5});
    EXPECT_EQ(scene.triangle_count, all);
}

TEST(Animation, PointersDriveCamerasLightsAndMaterials) {
    Scene scene = test::animated_file("Pointers").load();
    EXPECT_FALSE(scene.needs.area_lights);
    pose_scene(scene, {0, 0.5});
    ASSERT_EQ(scene.cameras.size(), 1u);
    EXPECT_FLOAT_EQ(scene.cameras[0].yfov, 0.75f);
    ASSERT_EQ(scene.punctual_lights.size(), 1u);
    EXPECT_EQ(scene.punctual_lights[0].intensity, Rgb(15, 7.5f, 0));
    EXPECT_FLOAT_EQ(scene.punctual_lights[0].cos_outer, std::cos(0.5f));
    ASSERT_EQ(scene.materials.size(), 1u);
    const Material& material = scene.materials[0];
    EXPECT_EQ(material.base_color, Rgb(0.5f, 0.25f, 0.5f));
    EXPECT_FLOAT_EQ(material.roughness, 0.25f);
    EXPECT_EQ(material.emission, Rgb(3, 3, 0)) << "the factor times the strength, both of which are driven";
    EXPECT_TRUE(scene.needs.area_lights);
    EXPECT_EQ(scene.triangle_lights.size(), 2u);
    EXPECT_EQ(material.base_color_texture.row_u, vec3(1, 0, 0.5f));
    EXPECT_TRUE(has_warning(scene, "/materials/0/occlusionTexture/strength, which is not rendered"));
    pose_scene(scene, {});
    EXPECT_FALSE(scene.needs.area_lights);
}

TEST(Animation, ValuesThatOvershootEndAtTheirRange) {
    Scene scene = test::animated_file("OvershootingSpline").load();
    pose_scene(scene, {0, 0.5});
    EXPECT_EQ(scene.materials[0].roughness, 1);
}

TEST(Animation, ProductsAndRangesEndAtTheirRange) {
    Scene scene = test::animated_file("ProductsOutOfRange").load();
    pose_scene(scene, {0, 1});
    constexpr float kMost = std::numeric_limits<float>::max();
    EXPECT_EQ(scene.materials[0].emission, Rgb(kMost, 1e30f, 0));
    EXPECT_EQ(scene.punctual_lights[0].intensity, Rgb(kMost, 1e30f, 0));
    EXPECT_EQ(scene.punctual_lights[0].range_m, 1);
    pose_scene(scene, {0, 0.5});
    EXPECT_GT(scene.punctual_lights[0].range_m, 0);
    EXPECT_LT(scene.punctual_lights[0].range_m, 1e-30f) << "below 0 it is the least, not unlimited";
}

void expect_bad_node(const std::function<void()>& act, const std::string& pointer, const std::string& detail) {
    try {
        act();
        ADD_FAILURE() << "is accepted";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::BadScene);
        ASSERT_FALSE(error.faults.empty());
        EXPECT_EQ(error.faults.front().pointer, pointer);
        EXPECT_NE(error.faults.front().detail.find(detail), std::string::npos) << error.faults.front().detail;
    }
}

TEST(Animation, TheCameraOfJobsThatNameNoneStaysTheSame) {
    Scene scene = test::animated_file("CamerasThatComeAndGo").load();
    for (const double time : {1.0, 0.0, 1.5}) {
        pose_scene(scene, {0, time});
        if (time < 1) {
            EXPECT_EQ(find_camera(scene, "").name, "first");
            EXPECT_EQ(find_camera(scene, "first").position, vec3(0, 0, 10));
        } else {
            expect_bad_node([&] { find_camera(scene, ""); }, "/nodes/2", "\"first\" cannot look at this moment");
            expect_bad_node([&] { find_camera(scene, "first"); }, "/nodes/2", "scaled to nothing");
        }
        EXPECT_EQ(find_camera(scene, "second").position, vec3(0, 0, 5));
    }
}

TEST(Animation, ACameraFramedOnTheSceneStandsStillWhileItMoves) {
    Scene scene = test::animated_file("LinearAndClamped").load();
    const Camera at_rest = find_camera(scene, "");
    pose_scene(scene, {0, 2});
    const Camera framed = find_camera(scene, "");
    EXPECT_NE(framed.position, at_rest.position) << "it goes far from where it rests";
    for (const double time : {0.3, 1.7}) {
        pose_scene(scene, {0, time});
        EXPECT_EQ(find_camera(scene, "").position, framed.position);
        Scene fresh = test::animated_file("LinearAndClamped").load();
        pose_scene(fresh, {0, time});
        EXPECT_EQ(find_camera(fresh, "").position, framed.position) << "whatever was shown before";
        // In the picture: nearer to the viewing line than the picture's edge.
        for (const vec3& p : scene.meshes[0].positions) {
            const dvec3 seen = dvec3(p) - dvec3(framed.position);
            const double depth = glm::dot(seen, dvec3(framed.forward));
            EXPECT_LT(std::fabs(glm::dot(seen, dvec3(framed.up))), depth * std::tan(0.5 * double{framed.yfov}));
            EXPECT_LT(std::fabs(glm::dot(seen, dvec3(framed.right))), depth * std::tan(0.5 * double{framed.yfov}));
        }
    }
    pose_scene(scene, {});
    EXPECT_EQ(find_camera(scene, "").position, at_rest.position);
}

TEST(Animation, CamerasAndLightsOutOfFloatsRangeAreRefused) {
    Scene scene = test::animated_file("CamerasThatComeAndGo").load();
    expect_bad_node([&] { pose_scene(scene, {0, 2}); }, "/nodes/2", "moves its camera out of float's range");
    expect_bad_node([&] { pose_scene(scene, {0, 3}); }, "/nodes/5", "moves its light out of float's range");
    pose_scene(scene, {0, 0});
    EXPECT_EQ(find_camera(scene, "").name, "first");
}

// As solids of glass the boxes overlap by a hair; as anything else they lie where the file puts them.
TEST(Animation, SolidsThatBecomeGlassOverlapForThatTimeAlone) {
    const auto positions = [](const Scene& scene) {
        return std::pair(scene.meshes[0].positions, scene.meshes[1].positions);
    };
    Scene scene = test::animated_file("SolidsThatAppear").load();
    ASSERT_EQ(scene.meshes.size(), 2u);
    const auto apart = positions(scene);
    EXPECT_EQ(scene.meshes[0].positions[6], vec3(1));
    const SceneChange appearing = pose_scene(scene, {0, 1});
    const auto overlapping = positions(scene);
    EXPECT_NE(overlapping, apart);
    EXPECT_EQ(appearing.moved.size() + appearing.reshaped.size(), 2u) << "structures must follow";
    EXPECT_EQ(pose_scene(scene, {0, 2}).moved.size(), 2u);
    EXPECT_EQ(positions(scene), apart) << "what was shown before leaves nothing";
    pose_scene(scene, {0, 0.5});
    EXPECT_EQ(positions(scene), overlapping);
    Scene fresh = test::animated_file("SolidsThatAppear").load();
    pose_scene(fresh, {0, 0.5});
    EXPECT_EQ(positions(fresh), overlapping);
}

TEST(Animation, GlassThatAppearsNeedsAnIndexAsGlassAtRestDoes) {
    try {
        test::animated_file("GlassWithoutAnIndex").load();
        ADD_FAILURE() << "loads";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::Unsupported);
        EXPECT_EQ(error.faults.front().pointer, "/animations/0/channels/0/target");
    }
}

TEST(Animation, ANodesWeightsWinOverItsMeshsThoughNoOtherNodeShowsIt) {
    Scene scene = test::animated_file("WeightsOfMeshAndNode").load();
    const vec3 stored = scene.meshes[0].positions[0];
    pose_scene(scene, {0, 1});
    EXPECT_EQ(scene.meshes[0].positions[0], stored + vec3(0, 0, 1)) << "the first target's, not the second's";
}

TEST(Animation, FaultsAreNamedWithTheirPlace) {
    for (const test::FaultyAnimation& faulty : test::faulty_animations()) {
        SCOPED_TRACE(faulty.name);
        try {
            faulty.gltf.load();
            ADD_FAILURE() << "loads";
        } catch (const Error& error) {
            EXPECT_EQ(error.code, ErrorCode::BadScene);
            ASSERT_FALSE(error.faults.empty());
            EXPECT_EQ(error.faults.front().pointer, faulty.pointer);
            EXPECT_NE(error.faults.front().detail.find(faulty.detail), std::string::npos)
                << error.faults.front().detail;
        }
    }
}

TEST(Animation, AnimationsThatAreNotThereAreRefused) {
    Scene scene = test::animated_file("ChildOfATurningParent").load();
    EXPECT_THROW(pose_scene(scene, {9, 0.5}), Error);
    pose_scene(scene, {0, 0.5});
    Scene still = test::plain_square().load();
    EXPECT_FALSE(still.rig);
    EXPECT_THROW(pose_scene(still, {0, 0.5}), Error);
    EXPECT_NO_THROW(pose_scene(still, {}));
}

}  // namespace
}  // namespace photond::animation_test
