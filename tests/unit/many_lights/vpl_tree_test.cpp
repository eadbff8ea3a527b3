#include "renderer/many_lights/vpl_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "renderer/photons/photon.h"
#include "tests/support/many_vpls.h"

namespace photond::vpl_tree_test {
namespace {

namespace stdx = std::experimental;
using test::exact_irradiance;
using test::on_one_wall;
using test::random_vpls;

/// Lights of the leaves below a node.
std::vector<uint32_t> lights_below(const VplTree& tree, uint32_t node) {
    uint32_t first = node, last = node;
    while (first < tree.leaves()) first = 2 * first, last = 2 * last + 1;
    std::vector<uint32_t> lights;
    for (uint32_t leaf = first; leaf <= last; ++leaf)
        if (tree.nodes()[leaf].light != NO_VPL) lights.push_back(tree.nodes()[leaf].light);
    return lights;
}

VplReceivers one_receiver(const vec3& position, const vec3& normal) {
    return {broadcast(position), broadcast(normal), FloatLanes(1)};
}

TEST(VplTree, EveryLightHasOneLeafAndNodesHoldWhatIsBelow) {
    for (const uint32_t count : {1u, 2u, 3u, 37u, 1000u, 1024u, 1025u}) {
        SCOPED_TRACE(count);
        const std::vector<Vpl> vpls = random_vpls(count, count, 0.1f);
        VplTree tree;
        tree.build(vpls);
        ASSERT_EQ(tree.nodes().size(), 2 * tree.leaves());
        EXPECT_EQ(tree.leaves(), vpl_tree_leaves(count));
        std::vector<uint32_t> all = lights_below(tree, VPL_TREE_ROOT);
        std::sort(all.begin(), all.end());
        ASSERT_EQ(all.size(), count);
        for (uint32_t i = 0; i < count; ++i) ASSERT_EQ(all[i], i);

        for (uint32_t index = VPL_TREE_ROOT; index < 2 * tree.leaves(); ++index) {
            const VplTreeNode& node = tree.nodes()[index];
            const std::vector<uint32_t> lights = lights_below(tree, index);
            double size = 0;
            for (const uint32_t light : lights) {
                const Vpl& vpl = vpls[light];
                size += vpl_size(vpl);
                for (int i = 0; i < 3; ++i) {
                    EXPECT_LE(node.low[i], vpl.position[i]);
                    EXPECT_GE(node.high[i], vpl.position[i]);
                }
                if (is_lambert(vpl)) {
                    EXPECT_GE(glm::dot(node.axis, vpl.normal), node.cos_cone - 1e-5f);
                } else {
                    EXPECT_EQ(node.cos_cone, -1);
                }
            }
            EXPECT_NEAR(node.intensity, size, 1e-5 * size);
        }
    }
}

TEST(VplTree, WithoutLightsTheRootIsEmpty) {
    VplTree tree;
    tree.build({});
    ASSERT_EQ(tree.nodes().size(), 2u);
    EXPECT_EQ(tree.nodes()[VPL_TREE_ROOT].intensity, 0);
    EXPECT_TRUE(stdx::all_of(vpl_bound(tree.nodes()[VPL_TREE_ROOT], one_receiver(vec3(0), vec3(0, 1, 0)), 0) == 0));
    std::vector<Vpl> dark = random_vpls(5, 1, 0);
    for (Vpl& vpl : dark) vpl.intensity = Rgb(0);
    tree.build(dark);
    EXPECT_EQ(tree.nodes()[VPL_TREE_ROOT].intensity, 0);
}

TEST(VplTree, LightsOfOneWallHaveOneNormal) {
    VplTree tree;
    tree.build(on_one_wall(500, 3));
    EXPECT_EQ(tree.nodes()[VPL_TREE_ROOT].cos_cone, 1);
    // Nothing comes to the wall itself, nor behind it.
    for (const float height : {0.0f, -0.5f})
        EXPECT_TRUE(stdx::all_of(
            vpl_bound(tree.nodes()[VPL_TREE_ROOT], one_receiver(vec3(0.3f, height, 3), vec3(0, 1, 0)), 0) == 0));
}

TEST(VplTree, NeighboursOnTheCurveAreNear) {
    constexpr uint32_t kLights = 4096;
    const std::vector<Vpl> vpls = random_vpls(kLights, 5, 0);
    VplTree tree;
    tree.build(vpls);
    double extent = 0;
    for (uint32_t i = 0; i < tree.leaves() / 16; ++i) {
        const VplTreeNode& node = tree.nodes()[tree.leaves() / 16 + i];
        extent += glm::length(node.high - node.low);
    }
    // Boxes of 16 lights in no order are about as long as the room, 8.7 m; in cells of equal size, 8.7 m / cbrt(256).
    EXPECT_LT(extent / (tree.leaves() / 16), 3);
}

TEST(VplTree, ManyLightsAtOnePlace) {
    std::vector<Vpl> vpls = random_vpls(100, 7, 0);
    for (Vpl& vpl : vpls) vpl.position = vec3(1, 2, 3);
    VplTree tree;
    tree.build(vpls);
    EXPECT_EQ(tree.nodes()[VPL_TREE_ROOT].low, vec3(1, 2, 3));
    EXPECT_EQ(tree.nodes()[VPL_TREE_ROOT].high, vec3(1, 2, 3));
    EXPECT_EQ(lights_below(tree, VPL_TREE_ROOT).size(), 100u);
}

/// No node may be said to bring less than its lights do: nodes of all levels, points about and far from them.
void expect_true_bounds(const std::vector<Vpl>& vpls, uint32_t seed, float clamp_sq_m2) {
    VplTree tree;
    tree.build(vpls);
    RandomStream random(seed, RandomDomain::Test, 0, 1);
    size_t tight = 0, checked = 0;
    for (int i = 0; i < 4000; ++i) {
        const float scale = i % 4 == 0 ? 50.0f : 5.0f;
        vec3 position = scale * (vec3(random.next(), random.next(), random.next()) - 0.5f);
        // Some at a light, or next to one.
        if (i % 4 == 1) {
            const Vpl& at = vpls[static_cast<size_t>(random.next() * static_cast<float>(vpls.size()))];
            position = at.position + (i % 8 == 1 ? 0.0f : 0.02f) * (position - at.position);
        }
        const vec3 normal = i % 16 == 2 ? vec3(0) : test::random_direction(random);
        const uint32_t level = static_cast<uint32_t>(random.next() * 11);
        const uint32_t index =
            std::min((1u << level) + static_cast<uint32_t>(random.next() * static_cast<float>(1u << level)),
                     2 * tree.leaves() - 1);
        double exact = 0;
        for (const uint32_t light : lights_below(tree, index))
            exact += max_component(exact_irradiance(vpls[light], position, normal, clamp_sq_m2));
        const float bound = vpl_bound(tree.nodes()[index], one_receiver(position, normal), clamp_sq_m2)[0];
        ASSERT_TRUE(std::isfinite(bound));
        // What rounding may take: of the product of the cosines.
        const float rounding = 1e-8f * tree.nodes()[index].intensity / clamp_sq_m2;
        ASSERT_LE(exact, bound * 1.00001 + rounding)
            << "node " << index << " at " << position.x << " " << position.y << " " << position.z;
        ++checked;
        if (exact > 0.5 * bound && bound > 0) ++tight;
    }
    EXPECT_GT(tight, checked / 50) << "bounds are too loose to be of use";
}

TEST(VplTree, BoundsHold) {
    expect_true_bounds(random_vpls(1000, 11, 0), 1, 1e-3f);
    expect_true_bounds(random_vpls(1000, 12, 0), 2, 0.1f);
    expect_true_bounds(on_one_wall(700, 13), 3, 1e-3f);
    std::vector<Vpl> few = random_vpls(30, 14, 0);
    expect_true_bounds(few, 4, 1e-6f);
    for (Vpl& vpl : few) vpl.position += vec3(1000, -2000, 500);
    expect_true_bounds(few, 5, 1e-3f);
}

TEST(VplTree, TheBoundOfOneLambertLightIsWhatItBrings) {
    const std::vector<Vpl> vpls = on_one_wall(1, 17);
    const VplTreeNode leaf = vpl_leaf(vpls[0], 0);
    RandomStream random(18, RandomDomain::Test, 0, 1);
    for (int i = 0; i < 1000; ++i) {
        const vec3 position = 5.0f * (vec3(random.next(), random.next(), random.next()) - 0.5f);
        const vec3 normal = test::random_direction(random);
        const float exact = max_component(exact_irradiance(vpls[0], position, normal, 0.01f));
        const float bound = vpl_bound(leaf, one_receiver(position, normal), 0.01f)[0];
        EXPECT_NEAR(bound, exact,
                    2e-3f * leaf.intensity /
                        std::max(glm::dot(position - vpls[0].position, position - vpls[0].position), 0.01f));
    }
}

TEST(VplTree, AHundredThousandLights) {
    const std::vector<Vpl> vpls = random_vpls(100'000, 19, 0.01f);
    VplTree tree;
    tree.build(vpls);
    double size = 0;
    for (const Vpl& vpl : vpls) size += vpl_size(vpl);
    EXPECT_EQ(tree.leaves(), 131'072u);
    EXPECT_NEAR(tree.nodes()[VPL_TREE_ROOT].intensity, size, 1e-5 * size);
    EXPECT_EQ(lights_below(tree, VPL_TREE_ROOT).size(), 100'000u);
    VplTree again;
    again.build(vpls);
    EXPECT_EQ(std::memcmp(tree.nodes().data(), again.nodes().data(), tree.nodes().size_bytes()), 0);
}

}  // namespace
}  // namespace photond::vpl_tree_test
