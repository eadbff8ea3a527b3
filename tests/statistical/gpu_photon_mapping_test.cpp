// Photon mapping on a GPU against the CPU's: the same image by the same numbers, and the same means by others.

#include <gtest/gtest.h>

#include "renderer/methods/photon_mapping/photon_mapping_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/gpu_render.h"
#include "tests/support/scene_parts.h"

namespace photond {
namespace {

struct Choice {
    const char* scene;
    Gather gather;
    PhotonSearch::Kind search;
};

template <class M>
test::RenderSettingsOf<M> settings_for(const Choice& choice) {
    test::RenderSettingsOf<M> settings;
    settings.size = {64, 64};
    settings.passes = 16;
    settings.params.photons = 6000;
    settings.params.indirect_bounces = 5;
    settings.params.gather = choice.gather;
    settings.params.gather_rays = 4;
    settings.params.search = choice.search;
    return settings;
}

/// The passes' mean image, and each pass's sums over blocks of 8 x 8 pixels, by channel.
struct Passes {
    std::vector<float> image;
    std::vector<test::RunningMean> blocks;

    void add(const Film& pass) {
        constexpr uint32_t kSide = 8;
        const std::vector<float> beauty = pass.resolve_beauty();
        const uint32_t width = pass.size().width, columns = width / kSide;
        image.resize(beauty.size());
        blocks.resize(beauty.size() / (kSide * kSide));
        std::vector<double> sums(blocks.size());
        for (uint32_t i = 0; i < beauty.size(); ++i) {
            const uint32_t x = i / 3 % width, y = i / 3 / width;
            image[i] += beauty[i];
            sums[3 * (y / kSide * columns + x / kSide) + i % 3] += beauty[i];
        }
        for (size_t i = 0; i < sums.size(); ++i) blocks[i].add(sums[i]);
    }
};

template <class M>
Passes render_passes(const RenderContext& context, const test::RenderSettingsOf<M>& settings) {
    Passes passes;
    Stats stats;
    test::run_passes_in(
        context, settings,
        [&](M& method, uint32_t pass) {
            Film film(settings.size, settings.layers, pass);
            method.resolve(film);
            passes.add(film);
        },
        stats);
    return passes;
}

class GpuPhotonMappingImages : public testing::TestWithParam<Choice> {};

// Turned out of its axes: along them a rounding error decides which of two frames a normal has, and all paths part.
// Else some in a thousand do, each a sample of its own right: by the same numbers images differ by less than 0.3 %,
// pixel by pixel. By other numbers blocks are compared, whose variance is that between passes, as pixels of a block
// share photons; false alarms: 1e-6 a choice, Sidak over its blocks and channels, Student's t with the least degrees of
// freedom that Welch's may be.
TEST_P(GpuPhotonMappingImages, AreTheCpusByTheSameNumbersAndInTheMean) {
    const Choice& choice = GetParam();
    const Scene scene = test::turned(make_builtin_scene(choice.scene));
    const test::SceneOnDevice where(scene);
    MemoryBudget budget;
    Stats stats;
    const std::unique_ptr<Intersector> rays = make_embree_intersector(scene, budget, stats);
    const auto on_cpu = settings_for<PhotonMapping>(choice);
    const auto on_gpu = settings_for<PhotonMappingGpu>(choice);
    const View view = test::view_of(scene, on_cpu);
    const auto gpu = [&](uint64_t seed) {
        return render_passes(RenderContext{scene, &where.intersector, view, seed, budget, &where.device_scene}, on_gpu);
    };
    const Passes cpu = render_passes(RenderContext{scene, rays.get(), view, 1, budget}, on_cpu);
    EXPECT_LT(test::mean_relative_difference(cpu.image, gpu(1).image), 0.003);

    const Passes other = gpu(2);
    const double limit = test::two_sided_t(test::share_of_false_alarm(1e-6, cpu.blocks.size()), on_cpu.passes - 1);
    for (size_t i = 0; i < cpu.blocks.size(); ++i) {
        const test::RunningMean &a = cpu.blocks[i], &b = other.blocks[i];
        const double error = std::hypot(a.standard_error(), b.standard_error());
        EXPECT_LE(std::fabs(a.mean() - b.mean()), limit * error + 1e-5 * a.mean()) << "block " << i / 3;
    }
}
constexpr PhotonSearch::Kind kNearest = PhotonSearch::Kind::Nearest, kRadius = PhotonSearch::Kind::Radius;
template <class Info>
std::string name_of(const Info& info) {
    return test::test_name(info.param.scene, info.index);
}
INSTANTIATE_TEST_SUITE_P(Choices, GpuPhotonMappingImages,
                         testing::Values(Choice{"cornell-box", Gather::Direct, kRadius},
                                         Choice{"cornell-box-glass", Gather::Direct, kNearest}),
                         name_of<testing::TestParamInfo<Choice>>);
INSTANTIATE_TEST_SUITE_P(LongChoices, GpuPhotonMappingImages,
                         testing::Values(Choice{"cornell-box", Gather::Final, kNearest},
                                         Choice{"cornell-box-glass", Gather::Final, kRadius}),
                         name_of<testing::TestParamInfo<Choice>>);

}  // namespace
}  // namespace photond
