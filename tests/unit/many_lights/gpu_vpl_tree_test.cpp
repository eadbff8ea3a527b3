// Trees over virtual lights on the device against those of the CPU, node by node.

#include <gtest/gtest.h>

#include "renderer/many_lights/vpl_tree.h"
#include "renderer/many_lights/vpl_tree_gpu.h"
#include "tests/support/gpu_twin.h"
#include "tests/support/many_vpls.h"

namespace photond::gpu_vpl_tree_test {
namespace {

using test::gpu_device;

/// Of the first `count` lights, in a tree with room for `most`.
void expect_the_hosts_tree(VplTreeGpu& tree, const std::vector<Vpl>& vpls, uint32_t count) {
    SCOPED_TRACE(count);
    gpu::Device& device = gpu_device();
    VplTree host;
    host.build(std::span(vpls).first(count));
    gpu::Buffer lights = gpu::make_buffer(device, "test vpls", std::span<const Vpl>(vpls));
    const std::vector<uint32_t> words = {77, count};
    gpu::Buffer counts = gpu::make_buffer(device, "test count", std::span<const uint32_t>(words));
    gpu::CommandList commands(device);
    commands.fill(tree.nodes(), 0xffffffff);
    tree.record(commands, lights, {counts, 1});
    commands.submit();
    commands.wait();
    const auto nodes = gpu::read_back<VplTreeNode>(device, tree.nodes(), host.nodes().size());
    for (uint32_t i = VPL_TREE_ROOT; i < nodes.size(); ++i) {
        const VplTreeNode &ours = nodes[i], &expected = host.nodes()[i];
        ASSERT_EQ(ours.intensity, expected.intensity) << "node " << i;
        ASSERT_EQ(ours.light, expected.light) << "node " << i;
        if (expected.intensity == 0) continue;
        ASSERT_EQ(ours.low, expected.low) << "node " << i;
        ASSERT_EQ(ours.high, expected.high) << "node " << i;
        ASSERT_LT(glm::length(ours.axis - expected.axis), 1e-3f) << "node " << i;
        ASSERT_NEAR(ours.cos_cone, expected.cos_cone, 1e-3) << "node " << i;
    }
}

TEST(GpuVplTree, IsTheHosts) {
    constexpr uint32_t kMost = 3000;
    const std::vector<Vpl> vpls = test::random_vpls(kMost, 1, 0.1f);
    const uint64_t before = gpu_device().memory().used_bytes();
    VplTreeGpu tree(gpu_device(), kMost);
    const auto taken = static_cast<double>(gpu_device().memory().used_bytes() - before);
    const auto expected = static_cast<double>(VplTreeGpu::device_bytes(kMost));
    EXPECT_NEAR(taken, expected, 0.1 * expected);
    for (const uint32_t count : {0u, 1u, 2u, 3u, 37u, 127u, 128u, 129u, 1000u, 2048u, 2049u, kMost})
        expect_the_hosts_tree(tree, vpls, count);
}

TEST(GpuVplTree, OfLightsFarOffAndOfLightsAtOnePlace) {
    VplTreeGpu tree(gpu_device(), 300);
    std::vector<Vpl> vpls = test::random_vpls(300, 2, 0);
    for (Vpl& vpl : vpls) vpl.position = 1e-3f * vpl.position + vec3(1000, -2000, 500);
    expect_the_hosts_tree(tree, vpls, 300);
    for (Vpl& vpl : vpls) vpl.position = vec3(-1, 2, 3);
    expect_the_hosts_tree(tree, vpls, 300);
    for (Vpl& vpl : vpls) vpl.intensity = Rgb(0);
    expect_the_hosts_tree(tree, vpls, 300);
}

TEST(GpuVplTree, OfAHundredThousandLights) {
    constexpr uint32_t kMost = 100'000;
    VplTreeGpu tree(gpu_device(), kMost);
    expect_the_hosts_tree(tree, test::random_vpls(kMost, 3, 0.01f), kMost);
}

TEST(GpuVplTree, MoreLightsThanThereIsRoomForAreLeftOut) {
    const std::vector<Vpl> vpls = test::random_vpls(500, 4, 0);
    VplTreeGpu tree(gpu_device(), 300);
    VplTree host;
    host.build(std::span(vpls).first(300));
    gpu::Buffer lights = gpu::make_buffer(gpu_device(), "test vpls", std::span<const Vpl>(vpls));
    const std::vector<uint32_t> words = {500};
    gpu::Buffer counts = gpu::make_buffer(gpu_device(), "test count", std::span<const uint32_t>(words));
    gpu::CommandList commands(gpu_device());
    tree.record(commands, lights, counts);
    commands.submit();
    commands.wait();
    const auto nodes = gpu::read_back<VplTreeNode>(gpu_device(), tree.nodes(), host.nodes().size());
    EXPECT_EQ(nodes[VPL_TREE_ROOT].intensity, host.nodes()[VPL_TREE_ROOT].intensity);
}

TEST(GpuVplTree, BoundsAreTheHosts) {
    struct Question {
        vec3 position;
        float clamp_sq_m2;
        vec3 normal;
    };
    VplTree tree;
    tree.build(test::random_vpls(1000, 5, 0.05f));
    RandomStream random(6, RandomDomain::Test, 0, 0);
    std::vector<VplTreeNode> nodes;
    std::vector<Question> questions;
    for (int i = 0; i < 20'000; ++i) {
        nodes.push_back(tree.nodes()[1 + static_cast<size_t>(random.next() * 2046)]);
        questions.push_back({6.0f * (vec3(random.next(), random.next(), random.next()) - 0.5f), 0.01f,
                             i % 16 == 0 ? vec3(0) : test::random_direction(random)});
    }
    const auto bounds =
        test::run_twin<float>("tests/gpu/vpl_bound.comp", nodes.size(), {{"nodes", nodes}, {"questions", questions}});
    for (size_t i = 0; i < nodes.size(); ++i) {
        const VplReceivers receiver{broadcast(questions[i].position), broadcast(questions[i].normal), FloatLanes(1)};
        const float expected = vpl_bound(nodes[i], receiver, questions[i].clamp_sq_m2)[0];
        // Sines of small angles and differences of squares lose half the digits.
        ASSERT_NEAR(bounds[i], expected, 2e-3 * expected + 1e-5 * nodes[i].intensity) << i;
    }
}

}  // namespace
}  // namespace photond::gpu_vpl_tree_test
