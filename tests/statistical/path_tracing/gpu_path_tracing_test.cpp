// Path tracing on a GPU and on the CPU are the same estimator: their images of every built-in scene agree, over the
// whole and block by block.

#include <gtest/gtest.h>

#include "renderer/methods/path_tracing/path_tracing_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/block_test.h"
#include "tests/support/gpu_render.h"
#include "tests/support/pipeline_layers.h"
#include "tests/support/scene_parts.h"

namespace photond::gpu_path_tracing_test {
namespace {

template <class M>
test::RenderSettingsOf<M> settings_for(uint64_t seed) {
    test::RenderSettingsOf<M> settings;
    settings.size = {24, 24};
    settings.passes = 128;
    settings.seed = seed;
    settings.layers = test::path_tracing_layers();
    settings.params.sampler = SamplerKind::Random;  // passes are independent
    settings.params.indirect_bounces = 6;
    return settings;
}

constexpr double kMustNotice = 1.0;  // of the light of half of the blocks

class GpuAgreement : public testing::TestWithParam<const char*> {};

// Both devices take the same random numbers, so that they differ by rounding alone and by the paths that it sends
// elsewhere: 0.3 % at most is asked of the means. The scene is turned because the sign of a zero decides between two
// frames where normals lie along axes, and with that the whole path.
TEST_P(GpuAgreement, MeansAgree) {
    const Scene scene = test::turned(make_builtin_scene(GetParam()));
    const test::SceneOnDevice where(scene);
    // By other numbers: independent samples of the same mean, block by block (false alarms: 1e-6 a scene).
    const test::ComparedRenders other =
        test::compare_blocks_when_sharp(scene, settings_for<PathTracing>(1), where, settings_for<PathTracingGpu>(2),
                                        {.side = 8, .must_notice = kMustNotice});
    EXPECT_EQ(other.test.alarms, 0u) << other.test.table();
    EXPECT_LE(other.test.half_notice, kMustNotice) << "too noisy to notice a defect";

    auto same_numbers = settings_for<PathTracingGpu>(1);
    same_numbers.passes = other.passes;
    const double mean_cpu = test::mean_of(other.first.resolve_beauty());
    const double mean_gpu = test::mean_of(test::render(where, same_numbers).resolve_beauty());
    std::printf("%s: %u passes, means %.2g apart\n", GetParam(), other.passes, mean_gpu / mean_cpu - 1);
    EXPECT_NEAR(mean_gpu / mean_cpu, 1.0, 0.003) << GetParam();
}
INSTANTIATE_TEST_SUITE_P(BuiltinScenes, GpuAgreement,
                         testing::Values("cornell-box", "cornell-box-spot", "cornell-box-glass", "cornell-box-glossy",
                                         "furnace", "caustic-ring", "keyhole", "interior", "photon-splatting/plate",
                                         "photon-splatting/skimming-ray", "photon-splatting/chairs"),
                         [](const auto& info) { return test::test_name(info.param, info.index); });

}  // namespace
}  // namespace photond::gpu_path_tracing_test
