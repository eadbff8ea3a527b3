// Animated files that make much of little: what many name is held once, and what is out of all proportion is refused.

#include <gtest/gtest.h>

#include "protocol/error.h"
#include "renderer/scene/gltf_loader.h"
#include "renderer/scene/pose.h"
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

void expect_refused(const TestGltf& file, const LoadLimits& limits, const std::string& pointer) {
    try {
        file.load(limits);
        ADD_FAILURE() << "loads";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::BadScene);
        ASSERT_FALSE(error.faults.empty());
        EXPECT_EQ(error.faults.front().pointer, pointer) << error.what();
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

}  // namespace
}  // namespace photond::animation_limits_test
