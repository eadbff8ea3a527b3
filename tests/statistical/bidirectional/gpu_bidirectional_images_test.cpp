// Vertex connection and merging on a GPU against the CPU's: the same image by the same numbers, and the same means by
// others.

#include <gtest/gtest.h>

#include <cstdio>

#include "renderer/bidirectional/bidirectional_method_gpu.h"
#include "renderer/methods/vertex_connection_and_merging/vertex_connection_and_merging.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/block_test.h"
#include "tests/support/gpu_render.h"
#include "tests/support/pipeline_layers.h"
#include "tests/support/scene_parts.h"

namespace photond::gpu_bidirectional_images_test {
namespace {

using Cpu = VertexConnectionAndMerging;
using Gpu = BidirectionalTwinGpu<VertexConnectionAndMerging>;

constexpr double kFalseAlarm = 1e-6;  // of each test
constexpr double kMostApart = 0.003;  // of the image's mean, by the same numbers
constexpr double kMustNotice = 0.3;   // of the light of half of the blocks, by others

constexpr const char* kScenes[] = {"cornell-box-glossy", "small-vcm/ceiling", "small-vcm/sky", "small-vcm/point"};

template <class M>
test::RenderSettingsOf<M> settings_for(uint32_t passes, uint64_t seed) {
    test::RenderSettingsOf<M> settings;
    settings.size = {40, 40};
    settings.passes = passes;
    settings.seed = seed;
    settings.layers = test::bidirectional_layers();
    settings.params.sampler = SamplerKind::Random;  // passes are independent
    settings.params.indirect_bounces = 6;
    settings.params.adapt = false;
    settings.params.light_paths = 0.5f;
    settings.params.merging_params.radius_relative = 0.03f;
    settings.params.merging_params.caustic_radius_share = 0.6f;
    settings.params.merging_params.weights = MergeWeights::Recursive;
    return settings;
}

/// The mean of the image, pass by pass.
template <class Where, class M>
std::vector<double> means_of_passes(const Where& where, const test::RenderSettingsOf<M>& settings) {
    std::vector<double> means;
    test::run_passes(where, settings, [&](M& method, uint32_t pass) {
        Film film(settings.size, settings.layers, pass);
        method.resolve(film);
        means.push_back(test::mean_of(film.resolve_beauty()));
    });
    return means;
}

// Where rounding sends a path of the light elsewhere, the cache holds one vertex more or less, and all connections of
// that pass may be others: such passes differ by noise, the rest by rounding. Their differences' own variance says how
// far from 0 the mean of those may lie.
TEST(GpuBidirectionalImages, AreTheCpusByTheSameNumbers) {
    constexpr uint32_t kPasses = 6;
    for (const char* name : kScenes) {
        SCOPED_TRACE(name);
        const Scene scene = test::turned(make_builtin_scene(name));
        const std::vector<double> cpu = means_of_passes(scene, settings_for<Cpu>(kPasses, 1));
        const std::vector<double> gpu = means_of_passes(test::SceneOnDevice(scene), settings_for<Gpu>(kPasses, 1));
        std::vector<double> apart;
        double mean = 0;
        for (uint32_t i = 0; i < kPasses; ++i) apart.push_back(gpu[i] - cpu[i]), mean += cpu[i] / kPasses;
        const test::Interval difference = test::mean_interval(apart, kFalseAlarm, std::size(kScenes));
        const double rounding = 1e-5 * mean;
        std::printf("%s: %.2g of the mean apart, %.2g would be noticed\n", name, difference.mean / mean,
                    (difference.half_width + rounding) / mean);
        EXPECT_LE(std::fabs(difference.mean), difference.half_width + rounding);
        EXPECT_LE(difference.half_width + rounding, kMostApart * mean) << "too far apart to notice a defect";
    }
}

TEST(GpuBidirectionalImages, HaveTheCpusMeanByOtherNumbers) {
    const Scene scene = make_builtin_scene("small-vcm/ceiling");
    const test::RenderedBlocks cpu = test::render_blocks(scene, settings_for<Cpu>(24, 1), 20);
    const test::RenderedBlocks gpu = test::render_blocks(test::SceneOnDevice(scene), settings_for<Gpu>(24, 2), 20);
    const test::BlockTest test = test::compare_blocks(cpu.blocks, gpu.blocks, kFalseAlarm);
    EXPECT_EQ(test.alarms, 0u) << test.table();
    EXPECT_LT(test.half_notice, kMustNotice) << "too noisy to notice a defect" << test.table();
    std::printf("half of the blocks notice %.2g\n", test.half_notice);
}

}  // namespace
}  // namespace photond::gpu_bidirectional_images_test
