// Photon splatting on a GPU and on the CPU are the same estimator: their images agree, over the whole and block by
// block, with each way of splatting and of starting paths.

#include <gtest/gtest.h>

#include "renderer/methods/photon_splatting/photon_splatting_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/block_test.h"
#include "tests/support/gpu_render.h"
#include "tests/support/pipeline_layers.h"
#include "tests/support/scene_parts.h"

namespace photond::gpu_photon_splatting_test {
namespace {

struct Case {
    const char* scene;
    void (*choose)(PhotonSplattingParams& params);
};

template <class M>
test::RenderSettingsOf<M> settings_for(const Case& which, uint64_t seed) {
    test::RenderSettingsOf<M> settings;
    settings.size = {32, 32};
    settings.passes = 32;
    settings.seed = seed;
    settings.layers = test::photon_splatting_layers();
    settings.params.sampler = SamplerKind::Random;  // passes are independent
    settings.params.photons = 600;
    settings.params.bounces = 2;
    settings.params.splat_size_relative = 0.4f;
    settings.params.shadow_resolution = 8;
    which.choose(settings.params);
    return settings;
}

constexpr double kMustNotice = 0.6;  // of the light of half of the blocks

class GpuSplattingAgreement : public testing::TestWithParam<Case> {};

// Both devices take the same random numbers, so that they differ by rounding alone and by the paths that it sends
// elsewhere; with splats that adapt or have several rays also by which of equally good numbers a splat takes, of some
// 15,000 photons. 0.3 % at most is asked of the means. The scene is turned: see test::turned().
TEST_P(GpuSplattingAgreement, MeansAgree) {
    const Case& which = GetParam();
    const Scene scene = test::turned(make_builtin_scene(which.scene));
    const test::SceneOnDevice where(scene);
    // By other numbers: independent samples of the same mean, block by block (false alarms: 1e-6 a case).
    const test::ComparedRenders other = test::compare_blocks_when_sharp(
        scene, settings_for<PhotonSplatting>(which, 1), where, settings_for<PhotonSplattingGpu>(which, 2),
        {.side = 8, .must_notice = kMustNotice, .first_look = 12});
    EXPECT_EQ(other.test.alarms, 0u) << other.test.table();
    EXPECT_LE(other.test.half_notice, kMustNotice) << "too noisy to notice a defect";

    auto same_numbers = settings_for<PhotonSplattingGpu>(which, 1);
    same_numbers.passes = other.passes;
    const Film gpu = test::render(where, same_numbers);
    const double ratio = test::mean_of(gpu.resolve_beauty()) / test::mean_of(other.first.resolve_beauty());
    std::printf("%s: %u passes, means %.2g apart\n", which.scene, other.passes, ratio - 1);
    EXPECT_NEAR(ratio, 1.0, 0.003);
}
template <class Info>
std::string name_of(const Info& info) {
    return test::test_name(info.param.scene, info.index);
}
INSTANTIATE_TEST_SUITE_P(Cases, GpuSplattingAgreement,
                         testing::Values(Case{"cornell-box", [](PhotonSplattingParams&) {}},
                                         Case{"cornell-box-glossy", [](PhotonSplattingParams& p) { p.bounces = 3; }},
                                         Case{"cornell-box-glass",
                                              [](PhotonSplattingParams& p) {
                                                  p.estimator = SplatEstimator::Kernel;
                                                  p.filter = SplatFilter::Tent;
                                              }},
                                         Case{"cornell-box",
                                              [](PhotonSplattingParams& p) {
                                                  p.weighting = SplatWeighting::Normalised;
                                                  p.filter = SplatFilter::Gaussian;
                                              }}),
                         name_of<testing::TestParamInfo<Case>>);
INSTANTIATE_TEST_SUITE_P(LongCases, GpuSplattingAgreement,
                         testing::Values(Case{"interior", [](PhotonSplattingParams& p) { p.ambient = 0.01f; }},
                                         Case{"cornell-box-spot",
                                              [](PhotonSplattingParams& p) {
                                                  p.bounces = 1;
                                                  p.injection = PhotonInjection::ReflectiveShadowMap;
                                                  p.filter = SplatFilter::Gaussian;
                                                  p.rays_per_photon = 3;
                                              }},
                                         Case{"cornell-box",
                                              [](PhotonSplattingParams& p) { p.visibility = p.repay = false; }}),
                         name_of<testing::TestParamInfo<Case>>);

}  // namespace
}  // namespace photond::gpu_photon_splatting_test
