// Photon splatting on a GPU: stratified photons and the blur, against the CPU's.

#include <gtest/gtest.h>

#include "renderer/methods/photon_splatting/photon_splatting_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/gpu_render.h"
#include "tests/support/scene_parts.h"
#include "tests/support/statistics.h"

namespace photond::gpu_splat_options_test {
namespace {

using Change = std::function<void(PhotonSplattingParams&)>;

constexpr Size2 kSize{40, 30};

struct Rendered {
    std::vector<std::vector<float>> passes;  // indirect layers
    Counts counts;
};

template <class M>
Rendered render(const RenderContext& context, const test::RenderSettingsOf<M>& settings) {
    Rendered rendered;
    Stats stats;
    test::run_passes_in(
        context, settings,
        [&](M& method, uint32_t pass) {
            Film film(settings.size, settings.layers, pass);
            method.resolve(film);
            rendered.passes.push_back(film.resolve(Layer::Indirect));
        },
        stats);
    rendered.counts = stats.counts;
    return rendered;
}

struct Both {
    Rendered cpu, gpu;
};
Both render_both(uint32_t passes, const Change& change) {
    // No normal has a 0, whose sign rounding would decide.
    const Scene scene = test::turned(make_builtin_scene("cornell-box"));
    const test::SceneOnDevice where(scene);
    MemoryBudget budget;
    Stats stats;
    const std::unique_ptr<Intersector> intersector = make_embree_intersector(scene, budget, stats);
    const auto settle = [&](auto settings) {
        settings.size = kSize;
        settings.passes = passes;
        settings.params.photons = 600;
        settings.params.bounces = 2;
        settings.params.adaptive_size = false;
        settings.params.shadow_resolution = 8;
        change(settings.params);
        return settings;
    };
    const auto cpu = settle(test::RenderSettingsOf<PhotonSplatting>());
    const auto gpu = settle(test::RenderSettingsOf<PhotonSplattingGpu>());
    const View view = test::view_of(scene, cpu);
    return {render<PhotonSplatting>({scene, intersector.get(), view, cpu.seed, budget}, cpu),
            render<PhotonSplattingGpu>({scene, &where.intersector, view, gpu.seed, budget, &where.device_scene}, gpu)};
}

double mean_of_channel(const std::vector<float>& image, size_t channel) {
    double sum = 0;
    for (size_t i = channel; i < image.size(); i += 3) sum += image[i];
    return sum / double(kSize.pixels());
}

struct Stratified {
    uint32_t rays;  // of a photon
    Change change;
};
class GpuStratifiedSplats : public testing::TestWithParam<Stratified> {};

// The photons are the CPU's in another order, and so are those of a cell: others of them are chosen, by the same
// chances. What the passes of the two differ by is noise of mean 0.
TEST_P(GpuStratifiedSplats, AgreeWithTheCpusInTheMean) {
    constexpr double kFalseAlarm = 1e-6, kMustDetect = 0.15;
    constexpr uint32_t kPasses = 40;
    const Both both = render_both(kPasses, GetParam().change);
    const Counts &a = both.cpu.counts, &b = both.gpu.counts;
    EXPECT_LT(a.splats, a.photons_stored * GetParam().rays * 9 / 10) << "stratified";
    EXPECT_NEAR(double(a.splats), double(b.splats), 0.01 * double(a.splats));
    for (size_t channel = 0; channel < 3; ++channel) {
        double mean = 0;
        std::vector<double> differences;
        for (uint32_t pass = 0; pass < kPasses; ++pass) {
            const double cpu = mean_of_channel(both.cpu.passes[pass], channel);
            differences.push_back(mean_of_channel(both.gpu.passes[pass], channel) - cpu);
            mean += cpu / kPasses;
        }
        const test::Interval found = test::mean_interval(differences, kFalseAlarm, 3);
        EXPECT_LE(std::fabs(found.mean), found.half_width) << channel;
        EXPECT_LE(found.half_width, kMustDetect * mean) << "too noisy to notice a defect";
    }
}
void stratify_into(PhotonSplattingParams& params, uint32_t cells, uint32_t minimum, uint32_t splats) {
    params.stratify = true;
    params.grid_cells = cells;
    params.minimum_photons = minimum;
    params.splats_per_cell = splats;
}
INSTANTIATE_TEST_SUITE_P(Options, GpuStratifiedSplats,
                         testing::Values(Stratified{1, [](auto& params) { stratify_into(params, 8, 1, 1); }},
                                         Stratified{3,
                                                    [](auto& params) {
                                                        stratify_into(params, 12, 2, 2);
                                                        params.splat_size_relative = 0.4f;
                                                        params.estimator = SplatEstimator::Kernel;
                                                        params.rays_per_photon = 3;
                                                        params.representative = Representative::Random;
                                                    }},
                                         Stratified{1, [](auto& params) {
                                                        stratify_into(params, 8, 1, 1);
                                                        params.weighting = SplatWeighting::Normalised;
                                                    }}));

TEST(GpuSplatBlur, IsTheCpus) {
    const auto difference = [](const Rendered& a, const Rendered& b) {
        return test::mean_relative_difference(a.passes.front(), b.passes.front());
    };
    const auto blurred = [](bool edges) {
        return render_both(1, [=](PhotonSplattingParams& params) {
            params.estimator = SplatEstimator::Kernel;
            params.blur = BlurWidth::Nine;
            params.blur_edges = edges;
        });
    };
    const Both plain = blurred(false), edges = blurred(true);
    EXPECT_LT(difference(plain.cpu, plain.gpu), 1e-4);
    EXPECT_LT(difference(edges.cpu, edges.gpu), 1e-4);
    EXPECT_GT(difference(plain.gpu, edges.gpu), 0.02);
}

}  // namespace
}  // namespace photond::gpu_splat_options_test
