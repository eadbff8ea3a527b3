// The consistent setting of visibility filtering: what is left of its bias after some passes, which falls.

#include <gtest/gtest.h>

#include "renderer/methods/visibility_filtering/visibility_filtering_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/open_scene.h"
#include "tests/support/path_render.h"

namespace photond::gpu_converging_passes_test {
namespace {

constexpr Size2 kSize{24, 18};
constexpr double kStandardErrors = 5.2;  // false alarms 2e-7

class GpuConvergingPassesLong : public testing::TestWithParam<const char*> {};

TEST_P(GpuConvergingPassesLong, ComeNearerToPathTracings) {
    const Scene scene = make_builtin_scene(GetParam());
    const test::SceneOnDevice where(scene);
    test::RenderSettings traced;
    traced.size = kSize;
    traced.passes = 20'000;
    traced.params.indirect_bounces = 1;
    traced.params.sampler = SamplerKind::Random;
    const test::RunningMean wanted = test::indirect_of_passes(scene, traced);
    test::RenderSettingsOf<VisibilityFilteringGpu> settings;
    settings.size = kSize;
    settings.passes = 64;
    settings.params.visibility = ProxyVisibility::Rays;
    settings.params.shrink = true;
    settings.params.subsampling = 1;
    settings.params.voxels = 6;
    settings.params.proxies = 6000;
    settings.params.sampler = SamplerKind::Random;
    std::vector<double> biases;
    double doubt = 0;
    for (const uint32_t first : {0u, 64u, 960u}) {
        settings.first_pass = first;
        const test::RunningMean found = test::indirect_of_passes(where, settings);
        biases.push_back(found.mean() / wanted.mean() - 1);
        doubt = kStandardErrors * std::hypot(found.standard_error(), wanted.standard_error()) / wanted.mean();
        std::printf("%s, passes %u to %u: bias %+.3f %%, %.3f in doubt\n", GetParam(), first,
                    first + settings.passes - 1, 100 * biases.back(), 100 * doubt);
    }
    EXPECT_LT(std::fabs(biases.back()), std::fabs(biases.front()));
    EXPECT_LT(doubt, 0.03) << "too noisy to notice a defect";
}

INSTANTIATE_TEST_SUITE_P(Long, GpuConvergingPassesLong, testing::Values("cornell-box", "cornell-box-spot"),
                         [](const auto& info) { return test::test_name(info.param, info.index); });

}  // namespace
}  // namespace photond::gpu_converging_passes_test
