// Progressive photon mapping on a GPU against its CPU twin: the same photons, eye paths and discs, but for rounding;
// and what a method promises beside.

#include <gtest/gtest.h>

#include "protocol/error.h"
#include "renderer/methods/probabilistic_progressive_photon_mapping/probabilistic_progressive_photon_mapping.h"
#include "renderer/methods/stochastic_progressive_photon_mapping/stochastic_progressive_photon_mapping.h"
#include "renderer/progressive/progressive_mapping_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/gpu_render.h"
#include "tests/support/pipeline_layers.h"
#include "tests/support/scene_parts.h"

namespace photond::gpu_progressive_mapping_test {
namespace {

using Stochastic = StochasticProgressivePhotonMapping;
using StochasticGpu = ProgressiveTwinGpu<StochasticProgressivePhotonMapping>;
using Probabilistic = ProbabilisticProgressivePhotonMapping;
using ProbabilisticGpu = ProgressiveTwinGpu<ProbabilisticProgressivePhotonMapping>;

struct Choice {
    const char* scene;
    RadiusRule rule;
    CurvatureTest test = CurvatureTest::Radial;
    DiscBoundary boundary = DiscBoundary::None;  // clipped discs take long where a processor plays the device
    std::optional<float> radius_relative{};
};

template <class M>
test::RenderSettingsOf<M> settings_for(const Choice& choice) {
    test::RenderSettingsOf<M> settings;
    settings.size = {28, 20};  // tiles cut at both edges
    settings.passes = 3;
    settings.layers = test::progressive_layers();
    settings.params.photons = 4000;
    settings.params.indirect_bounces = 6;
    settings.params.nearest_photons = 20;
    settings.params.radius_rule = choice.rule;
    settings.params.test = choice.test;
    settings.params.boundary = choice.boundary;
    settings.params.radius_relative = choice.radius_relative;
    return settings;
}

/// For what is to be the same to the bit, however few photons there are.
template <class M>
test::RenderSettingsOf<M> few_photons(const Choice& choice) {
    auto settings = settings_for<M>(choice);
    settings.params.photons = 1000;
    return settings;
}

class GpuProgressiveMapping : public testing::TestWithParam<Choice> {};

// A photon that rounding sends elsewhere shows in all pixels whose discs it was in, by about 1/20 of their light; and
// where a test was close, in the pixel's radius ever after.
template <class Cpu, class Gpu>
void expect_alike(const Choice& choice) {
    const Scene scene = test::turned(make_builtin_scene(choice.scene));
    Stats cpu_stats, gpu_stats;
    const Film cpu = test::render(scene, settings_for<Cpu>(choice), &cpu_stats);
    const Film gpu = test::render(test::SceneOnDevice(scene), settings_for<Gpu>(choice), &gpu_stats);
    for (const Layer layer : {Layer::Emitted, Layer::Direct})
        EXPECT_LT(test::share_apart(cpu.resolve(layer), gpu.resolve(layer), 1e-3), 0.02) << layer_info(layer).name;
    for (const Layer layer : {Layer::Indirect, Layer::Caustic, Layer::PhotonCount, Layer::Radius}) {
        EXPECT_LT(test::share_apart(cpu.resolve(layer), gpu.resolve(layer), 0.02), 0.05) << layer_info(layer).name;
        EXPECT_NEAR(test::mean_of(cpu.resolve(layer)), test::mean_of(gpu.resolve(layer)),
                    0.02 * test::mean_of(cpu.resolve(layer)))
            << layer_info(layer).name;
    }
    // Positive and negative: over the light that it is the bias of.
    const std::vector<float> a = cpu.resolve(Layer::BiasEstimate), b = gpu.resolve(Layer::BiasEstimate);
    double apart = 0;
    for (size_t i = 0; i < a.size(); ++i) apart += std::fabs(double{a[i]} - double{b[i]});
    EXPECT_LT(apart / double(a.size()), 0.02 * test::mean_of(cpu.resolve(Layer::Indirect)));
    const Counts &x = cpu_stats.counts, &y = gpu_stats.counts;
    const auto about = [](uint64_t p, uint64_t q) { return std::fabs(double(p) - double(q)) <= 0.01 * double(p) + 10; };
    EXPECT_TRUE(about(x.bounce_rays, y.bounce_rays)) << x.bounce_rays << ", " << y.bounce_rays;
    EXPECT_TRUE(about(x.shadow_rays, y.shadow_rays)) << x.shadow_rays << ", " << y.shadow_rays;
    EXPECT_EQ(x.photons_emitted, y.photons_emitted);
    EXPECT_TRUE(about(x.photon_rays, y.photon_rays)) << x.photon_rays << ", " << y.photon_rays;
    EXPECT_TRUE(about(x.photons_stored, y.photons_stored)) << x.photons_stored << ", " << y.photons_stored;
    EXPECT_EQ(gpu.nan_count() + gpu.infinity_count(), 0u);
}

TEST_P(GpuProgressiveMapping, LooksLikeTheCpus) {
    const Choice& choice = GetParam();
    if (choice.rule == RadiusRule::Global || choice.rule == RadiusRule::Trained)
        expect_alike<Probabilistic, ProbabilisticGpu>(choice);
    else
        expect_alike<Stochastic, StochasticGpu>(choice);
}
// Choices that several tests make, so that their pipelines are compiled once.
constexpr Choice kLocalGlass{"cornell-box-glass", RadiusRule::Local};
constexpr Choice kClippedBox{.scene = "cornell-box", .rule = RadiusRule::Local, .boundary = DiscBoundary::Clip};
constexpr Choice kTestedGlass{.scene = "cornell-box-glass", .rule = RadiusRule::Tested, .radius_relative = 0.05f};
constexpr Choice kGlobalTorus{"progressive/torus", RadiusRule::Global};
INSTANTIATE_TEST_SUITE_P(Choices, GpuProgressiveMapping,
                         testing::Values(kLocalGlass, kClippedBox,
                                         Choice{"cornell-box-glossy", RadiusRule::Tested, CurvatureTest::Sector},
                                         kTestedGlass, Choice{"cornell-box-glass", RadiusRule::Trained}, kGlobalTorus),
                         [](const auto& info) { return test::test_name(info.param.scene, info.index); });

TEST(GpuProgressiveMapping, PassesStandAloneByTheirIndex) {
    const Scene scene = make_builtin_scene(kGlobalTorus.scene);
    const test::SceneOnDevice where(scene);
    auto whole = few_photons<ProbabilisticGpu>(kGlobalTorus), first = whole, rest = whole;
    first.passes = 1;
    rest.passes = 2;
    rest.first_pass = 1;
    Film merged = test::render(where, first);
    merged.merge(test::render(where, rest));
    EXPECT_EQ(merged, test::render(where, whole));
}

RenderContext context_of(const test::SceneOnDevice& where, const test::RenderSettingsOf<StochasticGpu>& settings,
                         MemoryBudget& budget) {
    return {where.scene, &where.intersector, test::view_of(where.scene, settings), settings.seed,
            budget,      &where.device_scene};
}

TEST(GpuProgressiveMapping, RunsThatGoOnMakeTheSameBits) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    const test::SceneOnDevice where(scene);
    for (const Choice& choice : {kLocalGlass, kTestedGlass}) {
        const auto settings = few_photons<StochasticGpu>(choice);
        Film film(settings.size, settings.layers);
        std::string state;
        while (film.passes() < settings.passes) {
            MemoryBudget budget;
            Stats stats;
            StochasticGpu method(settings.params);
            if (film.passes() > 0) method.go_on_from(state);
            method.begin(context_of(where, settings, budget), stats);
            method.run_pass(film.next_pass(), stats, CancelToken{});
            method.resolve(film);
            state = method.state();
            // One that comes to nothing changes nothing.
            method.expect_pass(film.next_pass());
            CancelToken cancel;
            cancel.cancel();
            method.run_pass(film.next_pass(), stats, cancel);
            EXPECT_EQ(method.state(), state);
        }
        EXPECT_EQ(film, test::render(where, settings));
    }
}

TEST(GpuProgressiveMapping, GoesOnFromTheCpusState) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    const test::SceneOnDevice where(scene);
    const auto settings = settings_for<StochasticGpu>({"", RadiusRule::Local});
    MemoryBudget budget;
    Stats stats;
    const std::unique_ptr<Intersector> intersector = make_embree_intersector(scene, budget, stats);
    const RenderContext on_cpu{scene, intersector.get(), test::view_of(scene, settings), settings.seed, budget};
    Film film(settings.size, settings.layers);
    Stochastic cpu(settings.params);
    cpu.begin(on_cpu, stats);
    cpu.run_pass(0, stats, CancelToken{});
    cpu.resolve(film);
    StochasticGpu gpu(settings.params);
    gpu.go_on_from(cpu.state());
    gpu.begin(context_of(where, settings, budget), stats);
    EXPECT_EQ(gpu.state(), cpu.state());
    for (const uint32_t pass : {1u, 2u}) {
        gpu.run_pass(pass, stats, CancelToken{});
        gpu.resolve(film);
    }
    const Film whole = test::render(where, settings);
    EXPECT_LT(test::share_apart(film.resolve(Layer::Radius), whole.resolve(Layer::Radius), 0.02), 0.05);

    auto smaller = settings;
    smaller.size = {27, 20};
    StochasticGpu other(settings.params);
    other.go_on_from(gpu.state());
    try {
        other.begin(context_of(where, smaller, budget), stats);
        ADD_FAILURE() << "points of another image were taken";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::Conflict);
    }
}

// Without a bounce there is nothing that photons are for, and so there are no points either; a film goes on all the
// same.
TEST(GpuProgressiveMapping, GoesOnWithoutPhotons) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    auto settings = settings_for<StochasticGpu>(kClippedBox);
    settings.params.indirect_bounces = 0;
    settings.passes = 2;
    Film film(settings.size, settings.layers);
    std::string state;
    while (film.passes() < settings.passes) {
        MemoryBudget budget;
        Stats stats;
        StochasticGpu method(settings.params);
        if (film.passes() > 0) method.go_on_from(state);
        method.begin(context_of(where, settings, budget), stats);
        method.run_pass(film.next_pass(), stats, CancelToken{});
        method.resolve(film);
        state = method.state();
    }
    EXPECT_EQ(film, test::render(where, settings));
    EXPECT_EQ(test::mean_of(film.resolve(Layer::Indirect)), 0);
    EXPECT_GT(test::mean_of(film.resolve(Layer::Direct)), 0);
}

// In a white room a path leaves a photon at nearly each of its scatterings: more than there is room for, in the pilot
// as well.
TEST(GpuProgressiveMapping, LosesNoPhotonWhereThereAreMoreThanExpected) {
    Scene scene = test::turned(make_builtin_scene("cornell-box"));
    for (Material& material : scene.materials) material.base_color = Rgb(0.97f);
    auto settings = settings_for<Stochastic>(kClippedBox);
    auto on_gpu = settings_for<StochasticGpu>(kClippedBox);
    settings.params.indirect_bounces = on_gpu.params.indirect_bounces = 20;
    settings.passes = on_gpu.passes = 1;
    const Film cpu = test::render(scene, settings);
    const Film gpu = test::render(test::SceneOnDevice(scene), on_gpu);
    for (const Layer layer : {Layer::Indirect, Layer::Radius})
        EXPECT_NEAR(test::mean_of(gpu.resolve(layer)), test::mean_of(cpu.resolve(layer)),
                    0.01 * test::mean_of(cpu.resolve(layer)))
            << layer_info(layer).name;
}

TEST(GpuProgressiveMapping, TakesTheMemoryItSays) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    const test::SceneOnDevice where(scene);
    auto points = settings_for<StochasticGpu>({"", RadiusRule::Local});
    points.params.photons = 100'000;
    test::expect_device_bytes_as_estimated(where, points);
    auto trained = settings_for<ProbabilisticGpu>({"", RadiusRule::Trained});
    trained.params.photons = 100'000;
    test::expect_device_bytes_as_estimated(where, trained);
}

}  // namespace
}  // namespace photond::gpu_progressive_mapping_test
