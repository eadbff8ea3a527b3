// Vertex connection and merging on a GPU against its CPU twin: the same paths joined in the same ways, but for
// rounding; and what a method promises beside.

#include <gtest/gtest.h>

#include "renderer/bidirectional/bidirectional_method_gpu.h"
#include "renderer/methods/vertex_connection_and_merging/vertex_connection_and_merging.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/gpu_render.h"
#include "tests/support/pipeline_layers.h"
#include "tests/support/scene_parts.h"

namespace photond::gpu_bidirectional_method_test {
namespace {

using Cpu = VertexConnectionAndMerging;
using Gpu = BidirectionalTwinGpu<VertexConnectionAndMerging>;

struct Choice {
    const char* scene;
    Connections connections = Connections::Cache;
    MisHeuristic heuristic = MisHeuristic::Balance;
    PixelFilter filter = PixelFilter::Box;
    float aperture_relative = 0;
    bool orthographic = false;
    std::optional<uint32_t> bounces{};
    uint32_t connections_per_vertex = 1;
};

template <class M>
test::RenderSettingsOf<M> settings_for(const Choice& choice) {
    test::RenderSettingsOf<M> settings;
    settings.size = {28, 20};  // tiles cut at both edges
    settings.passes = 2;
    settings.filter = choice.filter;
    settings.layers = test::bidirectional_layers();
    settings.params.adapt = false;
    settings.params.light_paths = 4;
    settings.params.merging_params.radius_relative = 0.02f;
    settings.params.merging_params.weights = MergeWeights::Recursive;
    settings.params.connections = choice.connections;
    settings.params.heuristic = choice.heuristic;
    settings.params.indirect_bounces = choice.bounces;
    settings.params.connections_per_vertex = choice.connections_per_vertex;
    return settings;
}

class GpuBidirectionalMethod : public testing::TestWithParam<Choice> {};

// Turned out of its axes: along them a rounding error decides which of two frames a normal has, and all paths part. A
// path of the light that does part leaves other vertices, and all connections of its pass may go elsewhere.
TEST_P(GpuBidirectionalMethod, LooksLikeTheCpus) {
    const Choice& choice = GetParam();
    Scene scene = test::turned(make_builtin_scene(choice.scene));
    Camera& camera = scene.cameras[0];
    camera.orthographic = choice.orthographic;
    camera.ymag = 0.5f * scene.bounds.radius();
    camera.aperture_radius_m = choice.aperture_relative * scene.bounds.radius();
    camera.focus_distance_m = scene.bounds.radius();
    Stats cpu_stats, gpu_stats;
    const Film cpu = test::render(scene, settings_for<Cpu>(choice), &cpu_stats);
    const Film gpu = test::render(test::SceneOnDevice(scene), settings_for<Gpu>(choice), &gpu_stats);
    for (const Layer layer : {Layer::Emitted, Layer::Direct, Layer::Indirect, Layer::Caustic, Layer::Connections,
                              Layer::Merges, Layer::LightImage}) {
        const std::vector<float> a = cpu.resolve(layer), b = gpu.resolve(layer);
        EXPECT_LT(test::share_apart(a, b, 0.01), 0.02) << layer_info(layer).name;
        EXPECT_NEAR(test::mean_of(a), test::mean_of(b), 2e-3 * test::mean_of(a)) << layer_info(layer).name;
    }
    for (const Layer layer : {Layer::Indirect, Layer::Connections, Layer::Merges, Layer::LightImage})
        EXPECT_GT(test::mean_of(gpu.resolve(layer)), 0) << layer_info(layer).name;
    const Counts &x = cpu_stats.counts, &y = gpu_stats.counts;
    const auto about = [](uint64_t p, uint64_t q) { return std::fabs(double(p) - double(q)) <= 0.002 * double(p); };
    EXPECT_EQ(x.camera_rays, y.camera_rays);
    EXPECT_TRUE(about(x.bounce_rays, y.bounce_rays)) << x.bounce_rays << ", " << y.bounce_rays;
    EXPECT_TRUE(about(x.shadow_rays, y.shadow_rays)) << x.shadow_rays << ", " << y.shadow_rays;
    EXPECT_EQ(x.photons_emitted, y.photons_emitted);
    EXPECT_TRUE(about(x.photon_rays, y.photon_rays)) << x.photon_rays << ", " << y.photon_rays;
    EXPECT_TRUE(about(x.photons_stored, y.photons_stored)) << x.photons_stored << ", " << y.photons_stored;
    EXPECT_EQ(gpu.nan_count() + gpu.infinity_count(), 0u);
}
INSTANTIATE_TEST_SUITE_P(
    Choices, GpuBidirectionalMethod,
    testing::Values(Choice{.scene = "cornell-box",
                           .connections = Connections::OwnPath,
                           .heuristic = MisHeuristic::Power,
                           .filter = PixelFilter::BlackmanHarris},
                    Choice{.scene = "cornell-box-glossy", .filter = PixelFilter::Gaussian, .connections_per_vertex = 3},
                    Choice{.scene = "small-vcm/ceiling",
                           .connections = Connections::OwnPath,
                           .aperture_relative = 0.02f,
                           .bounces = 4},
                    Choice{.scene = "small-vcm/sky", .aperture_relative = 0.02f, .orthographic = true},
                    Choice{.scene = "small-vcm/point"}),
    [](const auto& info) { return test::test_name(info.param.scene, info.index); });

RenderContext context_of(const test::SceneOnDevice& where, const test::RenderSettingsOf<Gpu>& settings,
                         MemoryBudget& budget) {
    return {where.scene, &where.intersector, test::view_of(where.scene, settings), settings.seed,
            budget,      &where.device_scene};
}

/// What all else is tried in.
struct Place {
    Scene scene = make_builtin_scene("small-vcm/point");
    test::SceneOnDevice on_device{scene};
    test::RenderSettingsOf<Gpu> settings = settings_for<Gpu>({.scene = "", .connections_per_vertex = 2});
};

TEST(GpuBidirectionalMethod, PassesStandAloneByTheirIndex) {
    Place place;
    place.settings.passes = 3;
    auto first = place.settings, rest = place.settings;
    first.passes = 1;
    rest.passes = 2, rest.first_pass = 1;
    Film merged = test::render(place.on_device, first);
    merged.merge(test::render(place.on_device, rest));
    EXPECT_EQ(merged, test::render(place.on_device, place.settings));
}

// More pixels than paths a submit of a software device holds, and more light paths.
TEST(GpuBidirectionalMethod, PiecesMakeOneImage) {
    const Scene scene = test::turned(make_builtin_scene("small-vcm/point"));
    const Choice choice{.scene = "", .bounces = 1};
    auto settings = settings_for<Cpu>(choice);
    auto on_gpu = settings_for<Gpu>(choice);
    settings.size = on_gpu.size = {210, 170};
    settings.passes = on_gpu.passes = 1;
    settings.params.light_paths = on_gpu.params.light_paths = 1;
    const Film cpu = test::render(scene, settings);
    const Film gpu = test::render(test::SceneOnDevice(scene), on_gpu);
    for (const Layer layer : {Layer::Direct, Layer::Merges, Layer::LightImage})
        EXPECT_LT(test::share_apart(cpu.resolve(layer), gpu.resolve(layer), 0.01), 0.01) << layer_info(layer).name;
    const double mean = test::mean_of(cpu.resolve_beauty());
    EXPECT_NEAR(test::mean_of(gpu.resolve_beauty()), mean, 3e-3 * mean);
}

TEST(GpuBidirectionalMethod, CancelledPassesLeaveNothing) {
    const Place place;
    MemoryBudget budget;
    Stats stats;
    Gpu method(place.settings.params);
    method.begin(context_of(place.on_device, place.settings, budget), stats);
    Film film(place.settings.size, place.settings.layers);
    CancelToken cancel;
    cancel.cancel();
    method.run_pass(0, stats, cancel);
    method.resolve(film);
    EXPECT_EQ(film.passes(), 0u);
    for (const uint32_t pass : {0u, 1u}) {
        method.run_pass(pass, stats, CancelToken{});
        method.resolve(film);
    }
    EXPECT_EQ(film, test::render(place.on_device, place.settings));
}

// In a white room paths are long, and the pilot of an image of 16 pixels is as few paths: it may expect too little.
TEST(GpuBidirectionalMethod, LosesNoVertexWhereThereAreMoreThanExpected) {
    Scene scene = test::turned(make_builtin_scene("cornell-box"));
    for (Material& material : scene.materials) material.base_color = Rgb(0.99f);
    const Choice choice{.scene = "", .heuristic = MisHeuristic::Power};
    auto settings = settings_for<Cpu>(choice);
    auto on_gpu = settings_for<Gpu>(choice);
    settings.size = on_gpu.size = {4, 4};
    settings.passes = 1;
    settings.params.light_paths = on_gpu.params.light_paths = 16;
    const test::SceneOnDevice where(scene);
    size_t grown = 0;
    for (uint64_t seed = 1; seed <= 4; ++seed) {
        settings.seed = on_gpu.seed = seed;
        MemoryBudget budget;
        Stats cpu_stats, stats;
        Gpu method(on_gpu.params);
        method.begin(context_of(where, on_gpu, budget), stats);
        stats.counts = {};
        const uint64_t taken = test::gpu_device().memory().used_bytes();
        method.run_pass(0, stats, CancelToken{});
        grown += test::gpu_device().memory().used_bytes() > taken;
        Film gpu(on_gpu.size, on_gpu.layers);
        method.resolve(gpu);
        // Of so many scatterings rounding changes some, and with them all connections.
        const double mean = test::mean_of(test::render(scene, settings, &cpu_stats).resolve_beauty());
        EXPECT_NEAR(test::mean_of(gpu.resolve_beauty()), mean, 0.02 * mean);
        const auto stored = static_cast<double>(cpu_stats.counts.photons_stored);
        EXPECT_NEAR(static_cast<double>(stats.counts.photons_stored), stored, 0.02 * stored);
    }
    EXPECT_GT(grown, 0u);
}

// Where nothing is to be joined there is only the eye, on both devices.
TEST(GpuBidirectionalMethod, WithoutLightPathsThereIsOnlyTheEye) {
    const Scene scene = test::turned(make_builtin_scene("cornell-box"));
    auto settings = settings_for<Cpu>({.scene = ""});
    auto on_gpu = settings_for<Gpu>({.scene = ""});
    settings.params.light_paths = on_gpu.params.light_paths = 0;
    Stats stats;
    const Film gpu = test::render(test::SceneOnDevice(scene), on_gpu, &stats);
    EXPECT_LT(test::share_apart(test::render(scene, settings).resolve_beauty(), gpu.resolve_beauty(), 1e-3), 0.01);
    EXPECT_EQ(stats.counts.photons_emitted, 0u);
    EXPECT_EQ(test::mean_of(gpu.resolve(Layer::LightImage)), 0);
}

// They ask the device for their rays.
TEST(GpuBidirectionalMethod, PilotsChooseAsOnTheCpu) {
    for (const char* name : {"cornell-box", "small-vcm/point"}) {
        const Scene scene = test::turned(make_builtin_scene(name));
        auto settings = settings_for<Cpu>({.scene = ""});
        auto on_gpu = settings_for<Gpu>({.scene = ""});
        settings.params.adapt = on_gpu.params.adapt = true;
        settings.params.light_paths = on_gpu.params.light_paths = std::nullopt;
        settings.params.connections_per_vertex = on_gpu.params.connections_per_vertex = std::nullopt;
        settings.passes = on_gpu.passes = 1;
        Stats cpu_stats, gpu_stats;
        test::render(scene, settings, &cpu_stats);
        test::render(test::SceneOnDevice(scene), on_gpu, &gpu_stats);
        EXPECT_EQ(gpu_stats.counts.photons_emitted, cpu_stats.counts.photons_emitted) << name;
        const auto choices = [](const Stats& stats) {
            std::vector<std::string> skipped;
            for (const Skipped& part : stats.skipped)
                for (const char* what : {"light paths", "connections", "merging"})
                    if (part.what == what) skipped.push_back(what);
            return skipped;
        };
        EXPECT_EQ(choices(gpu_stats), choices(cpu_stats)) << name;
    }
}

TEST(GpuBidirectionalMethod, TakesTheMemoryItSays) {
    const Place place;
    auto settings = place.settings;
    settings.size = {256, 256};
    test::expect_device_bytes_as_estimated(place.on_device, settings);
}

TEST(GpuBidirectionalMethod, RefusesWhatOnlyTheCpuHas) {
    const auto pointer_of = [](auto change) -> std::string {
        VertexConnectionAndMergingParams params;
        change(params.merging_params);
        try {
            Gpu::check_gpu(params);
        } catch (const Error& error) {
            EXPECT_EQ(error.code, ErrorCode::Unsupported);
            return error.faults.at(0).pointer;
        }
        return "";
    };
    EXPECT_EQ(pointer_of([](MergingParams&) {}), "");
    EXPECT_EQ(pointer_of([](MergingParams& p) { p.weights = MergeWeights::Recursive; }), "");
    EXPECT_EQ(pointer_of([](MergingParams& p) { p.weights = MergeWeights::CorrelationAware; }), "/weights");
    EXPECT_EQ(pointer_of([](MergingParams& p) { p.radius_rule = RadiusRule::Trained; }), "/radius_rule");
}

}  // namespace
}  // namespace photond::gpu_bidirectional_method_test
