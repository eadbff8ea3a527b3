// Animated files that make much of little: what many name is held once, and what is out of all proportion is refused.

#include <gtest/gtest.h>

#include "protocol/error.h"
#include "renderer/scene/gltf_loader.h"
#include "renderer/scene/movers.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/rig_builder.h"
#include "tests/support/animated_gltf.h"
#include "tests/support/test_gltf.h"

namespace photond::animation_limits_test {
namespace {

std::string text(int number) { return std::to_string(number); }

/// Joins what `item` gives for 0 to `count` - 1 to a JSON array.
template <class Item>
std::string json_array(int count, const Item& item) {
    std::string list = "[";
    for (int i = 0; i < count; ++i) list += (i > 0 ? "," : "") + item(i);
    return list + "]";
}

/// A triangle's accessor.
int triangle(TestGltf& file) { return file.positions({0, 0, 0, 1, 0, 0, 0, 1, 0}); }

/// `pointer`: what the place of the complaint begins with.
void expect_refused(const TestGltf& file, const LoadLimits& limits, const std::string& pointer) {
    try {
        file.load(limits);
        ADD_FAILURE() << "loads";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::BadScene);
        ASSERT_FALSE(error.faults.empty());
        EXPECT_TRUE(error.faults.front().pointer.starts_with(pointer)) << error.faults.front().pointer;
    }
}

std::string sampler(int input, int output) {
    return R"({"input":)" + text(input) + R"(,"output":)" + text(output) + "}";
}
std::string channel(int sampler, int node, const char* path) {
    return R"({"sampler":)" + text(sampler) + R"(,"target":{"node":)" + text(node) + R"(,"path":")" + path + "\"}}";
}

/// As many nodes as `count` that show a triangle and are moved by keys of one pair of accessors, each by a sampler of
/// its own.
TestGltf moved_by_the_same_keys(int count, int keys) {
    TestGltf file;
    file.set_mesh(R"("POSITION":)" + text(triangle(file)));
    std::vector<float> times, values;
    for (int k = 0; k < keys; ++k) {
        times.push_back(static_cast<float>(k));
        values.insert(values.end(), {static_cast<float>(k), 0, 0});
    }
    const int input = file.floats("SCALAR", 1, times), output = file.positions(values);
    file.set("scenes", R"([{"nodes":)" + json_array(count, text) + "}]");
    file.set("nodes", json_array(count, [](int) { return std::string(R"({"mesh":0})"); }));
    file.set("animations", R"([{"samplers":)" + json_array(count, [&](int) { return sampler(input, output); }) +
                               R"(,"channels":)" +
                               json_array(count, [](int i) { return channel(i, i, "translation"); }) + "}]");
    return file;
}

TEST(AnimationLimits, KeysThatManySamplersNameAreHeldOnce) {
    constexpr int kNodes = 50, kKeys = 1000;
    const Scene scene = moved_by_the_same_keys(kNodes, kKeys).load();
    const std::vector<Channel>& channels = scene.rig->animations.at(0).channels;
    ASSERT_EQ(channels.size(), size_t{kNodes});
    for (const Channel& channel : channels) EXPECT_EQ(channel.keyframes, channels.front().keyframes);
    EXPECT_LT(scene.rig->bytes(), uint64_t{2} * kKeys * 16 + kNodes * 1000);
}

TEST(AnimationLimits, KeysInOtherAccessorsOfTheSameBytesAreCharged) {
    TestGltf file = moved_by_the_same_keys(3, 3000);
    LoadLimits limits;
    limits.max_made_bytes = 0;
    EXPECT_NO_THROW(file.load(limits)) << "they take as many bytes as in the file";
    // The second animation's accessors are others, of the views of the first one's.
    const int again = file.accessor(1, TestGltf::kF32, "SCALAR", 3000);
    const std::string first = file.member("animations");
    file.set("animations", first.substr(0, first.size() - 1) + R"(,{"samplers":[)" + sampler(again, 2) +
                               R"(],"channels":[)" + channel(0, 0, "translation") + "]}]");
    EXPECT_NO_THROW(file.load());
    expect_refused(file, limits, "/animations/1/samplers/0");
}

// --- morph targets ---------------------------------------------------------------------------------------------------
/// A list of so many points that they weigh more than what names them.
int many_points(TestGltf& file) {
    std::vector<float> points;
    for (int k = 0; k < 40; ++k) points.insert(points.end(), {static_cast<float>(k % 2), static_cast<float>(k / 2), 0});
    return file.positions(points);
}

/// A mesh of 1000 morph targets, all of them the same accessor.
TestGltf many_targets(const std::string& more_of_mesh = "") {
    TestGltf file;
    const int points = many_points(file);
    const int zeros = file.accessor(-1, TestGltf::kF32, "VEC3", 40);
    const std::string targets = json_array(1000, [&](int k) {
        return R"({"POSITION":)" + text(points) + R"(,"NORMAL":)" + text(k % 2 ? zeros : points) + "}";
    });
    file.set("meshes", R"([{"primitives":[{"attributes":{"POSITION":)" + text(points) + R"(},"mode":5,"targets":)" +
                           targets + "}]" + more_of_mesh + "}]");
    return file;
}

/// Two keys that drive the node's `path`, of that many numbers a key.
void animate(TestGltf& file, int node, const char* path, int width) {
    const int input = file.floats("SCALAR", 1, {0, 1});
    const std::vector<float> values(2 * static_cast<size_t>(width), 0.25f);
    const int output = width == 3 ? file.positions(values) : file.floats("SCALAR", 1, values);
    file.set("animations",
             R"([{"samplers":[)" + sampler(input, output) + R"(],"channels":[)" + channel(0, node, path) + "]}]");
}

TEST(AnimationLimits, MorphTargetsWithoutWeightsAreNotKept) {
    TestGltf file = many_targets(R"(,"weights":)" + json_array(1000, [](int k) { return text(k == 7); }));
    animate(file, 0, "translation", 3);
    LoadLimits limits;
    limits.max_made_bytes = 0;
    Scene scene = file.load(limits);
    const std::vector<MorphTarget>& targets = scene.rig->meshes.at(0).object->targets;
    ASSERT_EQ(targets.size(), 1u);
    EXPECT_EQ(targets[0].weight, 7u);
    pose_scene(scene, {0, 0});
    EXPECT_EQ(scene.meshes[0].positions[3], vec3(2, 2, 0) + vec3(0.25f)) << "twice (1, 1, 0), and the node's way";
}

TEST(AnimationLimits, MorphTargetsThatAreDrivenAreCharged) {
    TestGltf file = many_targets();
    animate(file, 0, "weights", 1000);
    EXPECT_EQ(file.load().rig->meshes.at(0).object->targets.size(), 1000u);
    LoadLimits limits;
    limits.max_made_bytes = 0;
    expect_refused(file, limits, "/meshes/0/primitives/0/targets/");
}

TEST(AnimationLimits, MorphTargetsOfNothingTakeNoPlace) {
    TestGltf file;
    const int points = many_points(file), zeros = file.accessor(-1, TestGltf::kF32, "VEC3", 40);
    file.set_mesh(R"("POSITION":)" + text(points), R"(,"mode":5,"targets":)" + json_array(1000, [&](int) {
                                                       return R"({"POSITION":)" + text(zeros) + "}";
                                                   }));
    animate(file, 0, "weights", 1000);
    EXPECT_TRUE(file.load().rig->meshes.at(0).object->targets.empty());
}

TEST(AnimationLimits, NodesOfOtherWeightsShareWhatIsReadOfTheirMesh) {
    TestGltf file = many_targets();
    file.set("scenes", R"([{"nodes":[0,1]}])");
    const std::string weights = json_array(1000, [](int k) { return text(k); });
    file.set("nodes", R"([{"mesh":0,"weights":)" + weights + R"(},{"mesh":0,"weights":)" + weights + "}]");
    const int input = file.floats("SCALAR", 1, {0, 1}), output = file.positions({0, 0, 0, 1, 0, 0});
    file.set("animations", R"([{"samplers":[)" + sampler(input, output) + R"(],"channels":[)" +
                               channel(0, 0, "translation") + "," + channel(0, 1, "translation") + "]}]");
    const Scene scene = file.load();
    ASSERT_EQ(scene.rig->meshes.size(), 2u);
    EXPECT_EQ(scene.rig->meshes[0].object, scene.rig->meshes[1].object);
}

// --- skins -----------------------------------------------------------------------------------------------------------
/// A mesh of so many primitives, on a skin of so many joints, the last of which is animated.
TestGltf skinned(int primitives, int joints) {
    TestGltf file;
    const int points = triangle(file);
    const int indices = file.accessor(file.view(std::vector<uint8_t>(12, 0)), TestGltf::kU8, "VEC4", 3);
    const int weights = file.floats("VEC4", 4, {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
    const std::string primitive = R"({"attributes":{"POSITION":)" + text(points) + R"(,"JOINTS_0":)" + text(indices) +
                                  R"(,"WEIGHTS_0":)" + text(weights) + "}}";
    file.set("meshes", R"([{"primitives":)" + json_array(primitives, [&](int) { return primitive; }) + "}]");
    file.set("skins", R"([{"joints":)" + json_array(joints, [](int k) { return text(k + 1); }) + "}]");
    file.set("scenes", R"([{"nodes":)" + json_array(joints + 1, text) + "}]");
    file.set("nodes",
             json_array(joints + 1, [](int k) { return std::string(k == 0 ? R"({"mesh":0,"skin":0})" : "{}"); }));
    animate(file, joints, "translation", 3);
    return file;
}

TEST(AnimationLimits, MeshesOnASkinShareItsMatrices) {
    constexpr int kMeshes = 200, kJoints = 200;
    Scene scene = skinned(kMeshes, kJoints).load();
    ASSERT_EQ(scene.rig->meshes.size(), size_t{kMeshes});
    EXPECT_LT(scene.posed->bytes(), uint64_t{kJoints} * 2000);
    EXPECT_EQ(pose_scene(scene, {0, 0.5}).moved.size(), size_t{kMeshes});
    EXPECT_TRUE(pose_scene(scene, {0, 1}).moved.empty()) << "both keys are the same";
    MemoryBudget budget;
    scene.account(budget);
    EXPECT_EQ(budget.structures().at("rig"), scene.rig->bytes() + scene.posed->bytes());
    EXPECT_GE(scene.rig->bytes(), kJoints * sizeof(dmat4));
}

TEST(AnimationLimits, JointsAreCharged) {
    LoadLimits limits;
    limits.max_made_bytes = 0;
    expect_refused(skinned(1, 1000), limits, "/skins/0/joints");
}

// --- what moves ------------------------------------------------------------------------------------------------------
TEST(AnimationLimits, MoversAreCountedByWhatTheyMove) {
    const auto movers = [](const char* name) { return count_movers(*test::animated_file(name).load().rig); };
    const std::vector<Movers> turning = movers("ChildOfATurningParent");
    ASSERT_EQ(turning.size(), 2u);
    EXPECT_EQ(turning[0].meshes, 2u) << "the parent and, by it, the child";
    EXPECT_EQ(turning[0].triangles, 4u);
    EXPECT_EQ(turning[1].meshes, 1u);
    const Movers hung = movers("HungOnNodes").at(0);
    EXPECT_EQ(hung.cameras, 1u);
    EXPECT_EQ(hung.lights, 1u);
    EXPECT_EQ(movers("Skin").at(0).meshes, 1u);
    EXPECT_EQ(movers("MorphWeights").at(0).meshes, 1u);
    const Movers driven = movers("Pointers").at(0);
    EXPECT_EQ(driven.cameras, 1u);
    EXPECT_EQ(driven.lights, 1u);
    EXPECT_EQ(driven.materials, 1u);
    EXPECT_EQ(driven.meshes, 0u);
}

TEST(AnimationLimits, AnimationsThatMoveTooMuchTogetherAreRefused) {
    Rig rig;
    for (int k = 0; k < 100; ++k) {
        RigNode node;
        node.parent = k - 1;
        add_node(rig, std::move(node));
    }
    rig.animations.resize(100);
    for (Animation& animation : rig.animations) animation.channels = {drive(Property::Translation, 0, {0}, {0, 0, 0})};
    EXPECT_EQ(count_movers(rig).size(), 100u);
    try {
        count_movers(rig, 5000);
        ADD_FAILURE() << "is counted";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::BadScene);
    }
}

}  // namespace
}  // namespace photond::animation_limits_test
