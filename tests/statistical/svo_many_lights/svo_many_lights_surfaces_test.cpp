// Many lights with rays for V against path tracing, by blocks of the image: mirrors, glass and glossy coats, which
// connections leave out and the short ray finds; several bounces; lights placed by the camera. Both are unbiased, by
// independent numbers; their passes' differences are summed over blocks of hundreds of pixels, near enough to normal
// for the test's limit (block_test.h; what skewness is left makes the glass box the bluntest).

#include <gtest/gtest.h>

#include "renderer/methods/svo_many_lights/svo_many_lights.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/block_test.h"
#include "tests/support/path_render.h"

namespace photond::svo_many_lights_surfaces_test {
namespace {

struct Case {
    const char* scene;
    uint32_t bounces, passes, block;
    double must_notice;  // by half of the blocks
    void (*set)(SvoManyLightsParams& params);
};
void PrintTo(const Case& which, std::ostream* out) { *out << which.scene << ", " << which.bounces << " bounces"; }

constexpr Size2 kSize{48, 48};

class SvoManyLightsSurfaces : public testing::TestWithParam<Case> {};

TEST_P(SvoManyLightsSurfaces, AreLitAsByPaths) {
    const Case& which = GetParam();
    const Scene scene = make_builtin_scene(which.scene);
    test::RenderSettings paths;
    paths.size = kSize, paths.passes = which.passes, paths.seed = 1;
    paths.params.indirect_bounces = which.bounces;
    paths.params.sampler = SamplerKind::Random;
    test::RenderSettingsOf<SvoManyLights> lights;
    lights.size = kSize, lights.passes = which.passes, lights.seed = 2;
    lights.params.vpls = 128;
    lights.params.map_resolution = 32;
    lights.params.bounces = which.bounces;
    lights.params.sampler = SamplerKind::Random;
    lights.params.caustic_photons = 0;  // which blur (svo_many_lights_caustic_test.cpp)
    which.set(lights.params);
    const test::ComparedRenders found = test::compare_blocks_when_sharp(
        scene, paths, scene, lights, {.side = which.block, .must_notice = which.must_notice, .first_look = 40});
    std::printf("%u passes: %s", found.passes, found.test.table(3).c_str());
    EXPECT_EQ(found.test.alarms, 0u) << found.test.table();
    EXPECT_LE(found.test.half_notice, which.must_notice) << "too noisy to notice a defect";
}

INSTANTIATE_TEST_SUITE_P(Scenes, SvoManyLightsSurfaces,
                         testing::Values(Case{"cornell-box-glossy", 1, 300, 16, 0.1, [](SvoManyLightsParams&) {}},
                                         Case{"cornell-box-glossy", 3, 300, 16, 0.1,
                                              [](SvoManyLightsParams& p) { p.vpl_choice = VplChoice::Interleaved; }},
                                         Case{"cornell-box-glass", 3, 300, 24, 0.3, [](SvoManyLightsParams&) {}},
                                         Case{"cornell-box", 4, 300, 16, 0.1,
                                              [](SvoManyLightsParams& p) { p.interleave = 2; }},
                                         Case{"cornell-box-spot", 2, 300, 16, 0.1,
                                              [](SvoManyLightsParams& p) { p.placement = VplPlacement::Camera; }},
                                         Case{"interior", 2, 120, 24, 0.3, [](SvoManyLightsParams&) {}}));

}  // namespace
}  // namespace photond::svo_many_lights_surfaces_test
