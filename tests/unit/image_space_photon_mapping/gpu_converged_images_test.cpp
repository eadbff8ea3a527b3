// Image-space photon mapping at its defaults, whose passes come to path tracing's image: what is left of the bias
// farther than a footprint from edges, where footprints are whole.

#include <gtest/gtest.h>

#include "renderer/methods/bidirectional_path_tracing/bidirectional_path_tracing.h"
#include "renderer/methods/image_space_photon_mapping/image_space_photon_mapping_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/gpu_render.h"
#include "tests/support/reference_images.h"
#include "tests/support/statistics.h"

namespace photond::gpu_converged_images_test {
namespace {

using Ispm = ImageSpacePhotonMappingGpu;

constexpr Size2 kSize{48, 36};
constexpr double kStandardErrors = 5.2;  // false alarms 2e-7

/// Of passes by themselves: the mean of the indirect layer over a mask, pass by pass. `where`: a scene, on a device or
/// not.
template <class M, class Where>
test::RunningMean means_of(const Where& where, const test::RenderSettingsOf<M>& settings, const test::Mask& mask) {
    test::RunningMean mean;
    test::run_passes(where, settings, [&](M& method, uint32_t pass) {
        Film film(settings.size, settings.layers, pass);
        method.resolve(film);
        const std::vector<float> image = film.resolve(Layer::Indirect);
        double sum = 0;
        for (size_t c = 0; c < 3; ++c) sum += test::masked_mean(image, c, mask) / 3;
        mean.add(sum);
    });
    return mean;
}

test::RenderSettingsOf<Ispm> passes_of(uint32_t first, uint32_t count) {
    test::RenderSettingsOf<Ispm> settings;
    settings.size = kSize;
    settings.first_pass = first;
    settings.passes = count;
    settings.params.sampler = SamplerKind::Random;
    return settings;
}

/// Less noisy than path tracing, which finds lamps in glass and gloss by chance.
test::RenderSettingsOf<BidirectionalPathTracing> unbiased(uint32_t passes) {
    test::RenderSettingsOf<BidirectionalPathTracing> settings;
    settings.size = kSize;
    settings.passes = passes;
    settings.seed = 5;
    settings.params.sampler = SamplerKind::Random;
    settings.params.adapt = false;
    return settings;
}

/// Pixels whose first surface is farther than that from edges.
test::Mask far_from_edges(const Scene& scene, float distance_m) {
    const std::vector<float> distances = test::distances_to_edges(scene, test::positions_seen(scene, kSize));
    test::Mask mask(distances.size());
    for (size_t i = 0; i < mask.size(); ++i) mask[i] = distances[i] > distance_m;
    return mask;
}

/// A scene, the passes of its reference, and how much of the mean may be in doubt: lamps that gloss and glass show make
/// few paths bright.
struct Case {
    const char* scene;
    uint32_t paths;
    double most_doubt;
};

class GpuConvergedImagesLong : public testing::TestWithParam<Case> {};

TEST_P(GpuConvergedImagesLong, ComeToPathTracings) {
    const auto& [name, paths, most_doubt] = GetParam();
    const Scene scene = make_builtin_scene(name);
    const test::SceneOnDevice where(scene);
    const float radius_m = passes_of(0, 1).params.radius_of_pass_m(0, scene.bounds.radius());
    const test::Mask mask = far_from_edges(scene, radius_m);
    const test::RunningMean wanted = means_of(scene, unbiased(paths), mask);
    const test::RunningMean found = means_of(where, passes_of(0, 256), mask);
    const double bias = found.mean() / wanted.mean() - 1;
    const double doubt = kStandardErrors * std::hypot(found.standard_error(), wanted.standard_error()) / wanted.mean();
    std::printf("%s: bias %+.3f %%, %.3f %% in doubt\n", name, 100 * bias, 100 * doubt);
    EXPECT_LT(std::fabs(bias), 0.005 + doubt);
    EXPECT_LT(doubt, most_doubt) << "too noisy to notice a defect";
}

INSTANTIATE_TEST_SUITE_P(Long, GpuConvergedImagesLong,
                         testing::Values(Case{"cornell-box", 3000, 0.01}, Case{"cornell-box-glossy", 4000, 0.04},
                                         Case{"cornell-box-glass", 6000, 0.03}, Case{"interior", 6000, 0.04}),
                         [](const auto& info) { return test::test_name(info.param.scene, info.index); });

// Whole footprints lose light at edges, for less the smaller they are: so the bias of later passes is less.
TEST(GpuConvergedImagesOfWholeFootprintsLong, BiasFallsWithPasses) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    const test::Mask everywhere(kSize.pixels(), true);
    const test::RunningMean wanted = means_of(scene, unbiased(400), everywhere);
    double first_bias = 0, bias_before = -1;
    for (const uint32_t first : {0u, 16u, 240u}) {
        test::RenderSettingsOf<Ispm> settings = passes_of(first, 16);
        settings.params.boundary = DiscBoundary::None;
        settings.params.radius_relative = 0.15f;
        const test::RunningMean found = means_of(where, settings, everywhere);
        const double bias = found.mean() / wanted.mean() - 1;
        const double doubt = kStandardErrors * found.standard_error() / wanted.mean();
        std::printf("passes from %u: bias %+.3f %%, %.3f %% in doubt\n", first, 100 * bias, 100 * doubt);
        EXPECT_LT(bias, -doubt) << "there is some";
        EXPECT_GT(bias, bias_before) << "nearer to none";
        if (first == 0) first_bias = bias;
        bias_before = bias;
    }
    // Radii are then about 0.56 times those of the first 16 passes; what is lost goes with them.
    EXPECT_NEAR(bias_before / first_bias, 0.56, 0.2);
}

}  // namespace
}  // namespace photond::gpu_converged_images_test
