// Photon mapping on a GPU against the CPU's: the same image by the same numbers, and the same means by others.

#include <gtest/gtest.h>

#include "renderer/methods/photon_mapping/photon_mapping_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/block_test.h"
#include "tests/support/gpu_render.h"
#include "tests/support/pipeline_layers.h"
#include "tests/support/scene_parts.h"

namespace photond::gpu_photon_mapping_test {
namespace {

struct Choice {
    const char* scene;
    Gather gather;
    PhotonSearch::Kind search;
    DiscBoundary boundary = DiscBoundary::None;
};

template <class M>
test::RenderSettingsOf<M> settings_for(const Choice& choice, uint64_t seed) {
    test::RenderSettingsOf<M> settings;
    settings.size = {64, 64};
    settings.passes = 20;
    settings.seed = seed;
    settings.layers = test::photon_mapping_layers();
    settings.params.light_samples = 2;
    settings.params.nearest_photons = 20;
    settings.params.caustic_nearest_photons = 40;
    settings.params.sampler = SamplerKind::Random;  // passes are independent
    settings.params.photons = 6000;
    settings.params.indirect_bounces = 6;
    settings.params.gather = choice.gather;
    settings.params.gather_rays = 5;
    settings.params.search = choice.search;
    settings.params.boundary = choice.boundary;
    return settings;
}

constexpr double kMustNotice = 0.3;  // of the light of half of the blocks

class GpuPhotonMappingImages : public testing::TestWithParam<Choice> {};

// Turned out of its axes: along them a rounding error decides which of two frames a normal has, and all paths part.
// Else some in a thousand do, each a sample of its own right: by the same numbers images differ by less than 0.3 %,
// pixel by pixel. By other numbers blocks are compared (false alarms: 1e-6 a choice).
TEST_P(GpuPhotonMappingImages, AreTheCpusByTheSameNumbersAndInTheMean) {
    const Choice& choice = GetParam();
    const Scene scene = test::turned(make_builtin_scene(choice.scene));
    const test::SceneOnDevice where(scene);
    const test::ComparedRenders other = test::compare_blocks_when_sharp(
        scene, settings_for<PhotonMapping>(choice, 1), where, settings_for<PhotonMappingGpu>(choice, 2),
        {.side = 8, .must_notice = kMustNotice});
    EXPECT_EQ(other.test.alarms, 0u) << other.test.table();
    EXPECT_LE(other.test.half_notice, kMustNotice) << "too noisy to notice a defect";

    auto same_numbers = settings_for<PhotonMappingGpu>(choice, 1);
    same_numbers.passes = other.passes;
    const Film gpu = test::render(where, same_numbers);
    const double apart = test::mean_relative_difference(other.first.resolve_beauty(), gpu.resolve_beauty());
    std::printf("%s: %u passes, %.2g apart\n", choice.scene, other.passes, apart);
    EXPECT_LT(apart, 0.003);
}
constexpr PhotonSearch::Kind kNearest = PhotonSearch::Kind::Nearest, kRadius = PhotonSearch::Kind::Radius;
template <class Info>
std::string name_of(const Info& info) {
    return test::test_name(info.param.scene, info.index);
}
INSTANTIATE_TEST_SUITE_P(Choices, GpuPhotonMappingImages,
                         testing::Values(Choice{"cornell-box", Gather::Direct, kRadius, DiscBoundary::Clip},
                                         Choice{"cornell-box-glass", Gather::Direct, kNearest}),
                         name_of<testing::TestParamInfo<Choice>>);
INSTANTIATE_TEST_SUITE_P(LongChoices, GpuPhotonMappingImages,
                         testing::Values(Choice{"cornell-box", Gather::Final, kNearest},
                                         Choice{"cornell-box-glass", Gather::Final, kRadius, DiscBoundary::Clip}),
                         name_of<testing::TestParamInfo<Choice>>);

}  // namespace
}  // namespace photond::gpu_photon_mapping_test
