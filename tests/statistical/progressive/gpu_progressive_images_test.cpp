// Progressive photon mapping on a GPU against the CPU's: the same image by the same numbers, and the same means by
// others.

#include <gtest/gtest.h>

#include "renderer/methods/probabilistic_progressive_photon_mapping/probabilistic_progressive_photon_mapping.h"
#include "renderer/methods/stochastic_progressive_photon_mapping/stochastic_progressive_photon_mapping.h"
#include "renderer/progressive/progressive_mapping_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/block_test.h"
#include "tests/support/gpu_render.h"
#include "tests/support/pipeline_layers.h"
#include "tests/support/scene_parts.h"

namespace photond::gpu_progressive_images_test {
namespace {

template <class M>
test::RenderSettingsOf<M> settings_for(RadiusRule rule, uint64_t seed, uint32_t passes = 8) {
    test::RenderSettingsOf<M> settings;
    settings.size = {48, 48};
    settings.passes = passes;
    settings.seed = seed;
    settings.layers = test::progressive_layers();
    settings.params.sampler = SamplerKind::Random;  // passes are independent
    settings.params.photons = 6000;
    settings.params.indirect_bounces = 6;
    settings.params.radius_rule = rule;
    settings.params.boundary = DiscBoundary::None;
    return settings;
}

constexpr double kMustNotice = 0.3;   // of the light of half of the blocks
constexpr double kMostApart = 0.003;  // by the same numbers, pixel by pixel

// Turned out of its axes: along them a rounding error decides which of two frames a normal has, and all paths part.
// Else some in a thousand do, each a sample of its own right.
TEST(GpuProgressiveImages, StandingAloneAreTheCpusByTheSameNumbersAndInTheMean) {
    using Cpu = ProbabilisticProgressivePhotonMapping;
    using Gpu = ProgressiveTwinGpu<ProbabilisticProgressivePhotonMapping>;
    const Scene scene = test::turned(make_builtin_scene("cornell-box-glass"));
    const test::SceneOnDevice where(scene);
    const auto settings = settings_for<Cpu>(RadiusRule::Trained, 1);
    const Film cpu = test::render(scene, settings);
    const Film gpu = test::render(where, settings_for<Gpu>(RadiusRule::Trained, 1));
    EXPECT_LT(test::mean_relative_difference(cpu.resolve_beauty(), gpu.resolve_beauty()), kMostApart);

    // By other numbers blocks are compared (false alarms: 1e-6); with radii of one pilot, so that they are of one mean.
    const auto with_radius = [](auto more) {
        more.params.radius_rule = RadiusRule::Global;
        more.params.radius_relative = 0.03f;
        return more;
    };
    constexpr uint32_t kMostPasses = 24;
    const test::ComparedRenders other = test::compare_blocks_when_sharp(
        scene, with_radius(settings_for<Cpu>(RadiusRule::Global, 1, kMostPasses)), where,
        with_radius(settings_for<Gpu>(RadiusRule::Global, 2, kMostPasses)), {.side = 8, .must_notice = kMustNotice});
    std::printf("%u passes, half of the blocks notice %.2g\n", other.passes, other.test.half_notice);
    EXPECT_EQ(other.test.alarms, 0u) << other.test.table();
    EXPECT_LE(other.test.half_notice, kMustNotice) << "too noisy to notice a defect";
}

// What a pixel has counted decides on the radii of all passes after: images may not part by more for that.
TEST(GpuProgressiveImages, BuildingOnOneAnotherAreTheCpusByTheSameNumbers) {
    using Cpu = StochasticProgressivePhotonMapping;
    using Gpu = ProgressiveTwinGpu<StochasticProgressivePhotonMapping>;
    const Scene scene = test::turned(make_builtin_scene("cornell-box-glass"));
    const test::SceneOnDevice where(scene);
    for (const RadiusRule rule : {RadiusRule::Local, RadiusRule::Tested}) {
        const Film cpu = test::render(scene, settings_for<Cpu>(rule, 1));
        const Film gpu = test::render(where, settings_for<Gpu>(rule, 1));
        EXPECT_LT(test::mean_relative_difference(cpu.resolve_beauty(), gpu.resolve_beauty()), kMostApart);
    }
}

}  // namespace
}  // namespace photond::gpu_progressive_images_test
