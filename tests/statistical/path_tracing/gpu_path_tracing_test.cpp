// Path tracing on a GPU and on the CPU are the same estimator: their images of every built-in scene agree, over the
// whole and block by block.

#include <gtest/gtest.h>

#include "renderer/methods/path_tracing/path_tracing_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/block_test.h"
#include "tests/support/gpu_render.h"
#include "tests/support/scene_parts.h"

namespace photond::gpu_path_tracing_test {
namespace {

template <class M>
test::RenderSettingsOf<M> settings_for(uint64_t seed) {
    test::RenderSettingsOf<M> settings;
    settings.size = {32, 32};
    settings.passes = 128;
    settings.seed = seed;
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
    const test::RenderedBlocks cpu = test::render_blocks(scene, settings_for<PathTracing>(1), 8);
    const Film gpu = test::render(where, settings_for<PathTracingGpu>(1));
    const double mean_cpu = test::mean_of(cpu.film.resolve_beauty()), mean_gpu = test::mean_of(gpu.resolve_beauty());
    EXPECT_NEAR(mean_gpu / mean_cpu, 1.0, 0.003) << GetParam();

    // By other numbers: independent samples of the same mean, block by block (false alarms: 1e-6 a scene).
    const test::RenderedBlocks other = test::render_blocks(where, settings_for<PathTracingGpu>(2), 8);
    const test::BlockTest test = test::compare_blocks(cpu.blocks, other.blocks);
    EXPECT_EQ(test.alarms, 0u) << test.table();
    EXPECT_LT(test.half_notice, kMustNotice) << "too noisy to notice a defect";
}
INSTANTIATE_TEST_SUITE_P(BuiltinScenes, GpuAgreement,
                         testing::Values("cornell-box", "cornell-box-spot", "cornell-box-glass", "cornell-box-glossy",
                                         "furnace", "caustic-ring", "keyhole", "interior", "photon-splatting/plate",
                                         "photon-splatting/skimming-ray", "photon-splatting/chairs"),
                         [](const auto& info) { return test::test_name(info.param, info.index); });

}  // namespace
}  // namespace photond::gpu_path_tracing_test
