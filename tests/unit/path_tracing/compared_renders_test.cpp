// Renders that are compared by looks: two of one estimator end early without an alarm, and a brighter lamp is noticed.

#include <gtest/gtest.h>

#include "renderer/scene/builtin_scenes.h"
#include "tests/support/block_test.h"
#include "tests/support/path_render.h"

namespace photond::compared_renders_test {
namespace {

test::RenderSettings settings_of(uint64_t seed) {
    test::RenderSettings settings;
    settings.size = {16, 16};
    settings.passes = 400;
    settings.seed = seed;
    settings.params.sampler = SamplerKind::Random;
    return settings;
}

constexpr test::BlockLooks kLooks{.side = 8, .must_notice = 0.3};

TEST(ComparedRenders, OfOneEstimatorEndWhenHalfOfTheBlocksAreSharp) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::ComparedRenders found =
        test::compare_blocks_when_sharp(scene, settings_of(1), scene, settings_of(2), kLooks);
    EXPECT_EQ(found.test.alarms, 0u) << found.test.table();
    EXPECT_LE(found.test.half_notice, kLooks.must_notice);
    EXPECT_GT(found.passes, kLooks.first_look) << "the first look is too early for this scene";
    EXPECT_LT(found.passes, settings_of(1).passes);

    test::RenderSettings same = settings_of(1);
    same.passes = found.passes;
    EXPECT_EQ(found.first, test::render(scene, same)) << "stages make the film of one run";
}

TEST(ComparedRenders, NoticeABrighterLamp) {
    const Scene scene = make_builtin_scene("cornell-box");
    Scene brighter = scene;
    for (Material& material : brighter.materials) material.emission *= 1.5f;
    finish_scene(brighter);
    const test::ComparedRenders found =
        test::compare_blocks_when_sharp(scene, settings_of(1), brighter, settings_of(2), kLooks);
    EXPECT_GT(found.test.alarms, 0u) << found.test.table();
}

TEST(ComparedRenders, NeedAsManyPassesOfBoth) {
    const Scene scene = make_builtin_scene("cornell-box");
    test::RenderSettings fewer = settings_of(2);
    fewer.passes = 10;
    EXPECT_THROW(test::compare_blocks_when_sharp(scene, settings_of(1), scene, fewer, kLooks), std::invalid_argument);
}

}  // namespace
}  // namespace photond::compared_renders_test
