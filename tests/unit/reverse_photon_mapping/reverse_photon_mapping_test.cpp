// Reverse photon mapping against photon mapping: the same image where the radius is fixed, and the same mean where each
// photon has its own; and what it promises beside: bits that depend neither on threads nor on tiles, and its memory.

#include "renderer/methods/reverse_photon_mapping/reverse_photon_mapping.h"

#include <gtest/gtest.h>

#include "protocol/error.h"
#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/hard_scenes.h"
#include "tests/support/render.h"
#include "tests/support/statistics.h"
#include "tests/support/threads.h"

namespace photond::reverse_photon_mapping_test {
namespace {

using Reverse = test::RenderSettingsOf<ReversePhotonMapping>;
using Forward = test::RenderSettingsOf<PhotonMapping>;

Reverse reverse_settings() {
    Reverse settings;
    settings.size = {24, 20};  // tiles cut at both edges
    settings.layers.add(Layer::Caustic);
    settings.layers.add(Layer::PhotonCount);
    settings.params.photons = 20'000;
    settings.params.gather_rays = 16;
    settings.params.radius_relative = 0.06f;
    settings.params.influence_radius = InfluenceRadius::Fixed;  // by which pairs are photon mapping's
    return settings;
}

/// Photon mapping that looks the same discs up. `search`: by hash grid, or by kd-tree all that are near.
Forward forward_settings(const Reverse& reverse, PhotonSearch::Kind search) {
    Forward forward;
    forward.size = reverse.size;
    forward.layers = reverse.layers;
    forward.passes = reverse.passes;
    forward.seed = reverse.seed;
    static_cast<GatheringParams&>(forward.params) = reverse.params;
    forward.params.precompute_irradiance = false;
    forward.params.search = search;
    if (search == PhotonSearch::Kind::Nearest) forward.params.nearest_photons = 100'000;
    return forward;
}

/// Sums of as many floats as an image has, each rounded, differ by this share of a pixel or of the mean.
constexpr double kRounding = 1e-5;

void expect_same_image(const Scene& scene, const Reverse& settings,
                       PhotonSearch::Kind search = PhotonSearch::Kind::Radius) {
    const Film ours = test::render(scene, settings), theirs = test::render(scene, forward_settings(settings, search));
    for (const Layer layer : {Layer::Direct, Layer::Indirect, Layer::Caustic}) {
        const std::vector<float> a = ours.resolve(layer), b = theirs.resolve(layer);
        const double mean = test::mean_of(b);
        double most = 0;
        for (size_t i = 0; i < a.size(); ++i)
            most = std::max(most, std::abs(double(a[i]) - double(b[i])) / std::max(mean, double(b[i])));
        EXPECT_LE(most, mean > 0 ? kRounding : 0) << "layer " << int(layer);
        EXPECT_TRUE(mean > 0 || layer != Layer::Indirect);
    }
    // Of the same discs the same photons.
    EXPECT_EQ(ours.resolve(Layer::PhotonCount), theirs.resolve(Layer::PhotonCount));
}

TEST(ReversePhotonMapping, IsTheImageOfForwardGatheringWhereTheRadiusIsFixed) {
    for (const char* name : {"cornell-box", "cornell-box-glass", "cornell-box-glossy", "interior"}) {
        const Scene scene = make_builtin_scene(name);
        for (const DiscBoundary boundary : {DiscBoundary::None, DiscBoundary::Clip}) {
            SCOPED_TRACE(testing::Message() << name << ", boundary " << int(boundary));
            Reverse settings = reverse_settings();
            settings.params.boundary = boundary;
            expect_same_image(scene, settings);
        }
    }
}

TEST(ReversePhotonMapping, IsTheImageOfASearchByKdTree) {
    Reverse settings = reverse_settings();
    settings.params.boundary = DiscBoundary::None;
    expect_same_image(make_builtin_scene("cornell-box"), settings, PhotonSearch::Kind::Nearest);
}

TEST(ReversePhotonMapping, IsTheImageOfForwardGatheringWithEveryParameterOfTheEstimate) {
    const Scene scene = make_builtin_scene("cornell-box-glossy");
    Reverse settings = reverse_settings();
    settings.params.boundary = DiscBoundary::None;
    for (const KernelShape kernel : {KernelShape::Cone, KernelShape::Gaussian, KernelShape::Epanechnikov}) {
        SCOPED_TRACE(testing::Message() << "kernel " << int(kernel));
        settings.params.kernel = kernel;
        expect_same_image(scene, settings);
    }
    settings.params.soft_disc = true;
    expect_same_image(scene, settings);
    settings.params.soft_disc = false;
    settings.params.disc_thickness_m = 0.003f;
    expect_same_image(scene, settings);
    settings.params.indirect_bounces = 3;
    expect_same_image(scene, settings);
    settings.params.gather_sampling = GatherSampling::Photons;
    settings.params.shadow_photons = true;
    expect_same_image(scene, settings);
}

TEST(ReversePhotonMapping, PixelHashDependsNeitherOnThreadsNorOnTiles) {
    for (const char* name : {"cornell-box-glass", "interior"}) {
        const Scene scene = make_builtin_scene(name);
        for (const InfluenceRadius influence : {InfluenceRadius::Fixed, InfluenceRadius::Knn, InfluenceRadius::Leaf}) {
            Reverse settings = reverse_settings();
            settings.passes = 2;
            settings.params.photons = 5000;
            settings.params.gather_rays = 32;
            settings.params.influence_radius = influence;
            settings.params.boundary = DiscBoundary::None;
            const auto hash = [&](int threads, uint32_t tile_points) {
                settings.params.tile_points = tile_points;
                return test::on_threads(threads, [&] { return test::render(scene, settings).pixel_hash(); });
            };
            const std::string whole = hash(1, 1 << 18);
            EXPECT_EQ(whole, hash(2, 1 << 18)) << name;
            EXPECT_EQ(whole, hash(8, 1024)) << name;  // some twenty tiles a pass
            EXPECT_EQ(whole, hash(1, 5000)) << name;
        }
    }
}

TEST(ReversePhotonMapping, APassIsAPureFunctionOfItsIndex) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    Reverse settings = reverse_settings();
    settings.passes = 3;
    Film all(settings.size, settings.layers), last(settings.size, settings.layers);
    test::run_passes(scene, settings, [&](ReversePhotonMapping& method, uint32_t pass) {
        if (pass == 2) method.resolve(last);
    });
    settings.first_pass = 2;
    settings.passes = 1;
    EXPECT_EQ(last.resolve(Layer::Indirect), test::render(scene, settings).resolve(Layer::Indirect));
}

// Discs of each photon's own size, as large as hold k photons where it lies, against discs at the points that hold as
// many: what is left of a difference is both estimates' bias, which is of the second order in the radius, and of k
// nearest photons' radius itself, of the order 1/k.
TEST(ReversePhotonMapping, RadiiOfPhotonsBringTheSameMeanAsThoseOfPoints) {
    constexpr double kFalseAlarm = 1e-6, kBias = 0.02, kMustDetect = 0.04;
    for (const char* name : {"cornell-box", "interior"}) {
        const Scene scene = make_builtin_scene(name);
        for (const InfluenceRadius influence : {InfluenceRadius::Knn, InfluenceRadius::Leaf}) {
            std::vector<double> differences;
            for (uint64_t seed = 1; seed <= 8; ++seed) {
                Reverse settings = reverse_settings();
                settings.seed = seed;
                settings.params.photons = 50'000;
                settings.params.influence_radius = influence;
                settings.params.radius_relative = 0.1f;
                settings.params.boundary = DiscBoundary::None;
                Forward forward = forward_settings(settings, PhotonSearch::Kind::Nearest);
                forward.params.nearest_photons = settings.params.nearest_photons;
                const auto indirect = [&](const auto& with) {
                    return test::mean_of(test::render(scene, with).resolve(Layer::Indirect));
                };
                differences.push_back(indirect(settings) / indirect(forward) - 1);
            }
            const test::Interval interval = test::mean_interval(differences, kFalseAlarm, 4);
            std::printf("%s, influence %d: relative difference %.4f +- %.4f\n", name, int(influence), interval.mean,
                        interval.half_width);
            EXPECT_LE(std::abs(interval.mean), kBias + interval.half_width) << name;
            EXPECT_LE(interval.half_width, kMustDetect) << "too noisy to notice a defect";
        }
    }
}

// Where an edge is near, the maps are looked up at the points, whatever the photons' radii: no light is lost there.
TEST(ReversePhotonMapping, LightIsWholeInAFurnace) {
    constexpr double kFalseAlarm = 1e-6, kMustDetect = 0.02;
    const Scene scene = make_builtin_scene("hard-case/furnace-albedo-50");  // radiance 1 / (1 - 0.5) everywhere
    for (const InfluenceRadius influence : {InfluenceRadius::Fixed, InfluenceRadius::Knn, InfluenceRadius::Leaf}) {
        const test::Interval mean =
            test::interval_when_narrow(0.5 * kMustDetect, 16, kFalseAlarm, 3, [&](uint64_t seed) {
                Reverse settings = reverse_settings();
                settings.seed = seed;
                settings.params.influence_radius = influence;
                Forward forward = forward_settings(settings, PhotonSearch::Kind::Nearest);
                forward.params.nearest_photons = settings.params.nearest_photons;
                const auto beauty = [&](const auto& with) {
                    return test::mean_of(test::render(scene, with).resolve_beauty());
                };
                return beauty(settings) / beauty(forward);
            });
        std::printf("influence %d: %.5f +- %.5f\n", int(influence), mean.mean, mean.half_width);
        EXPECT_LE(std::abs(mean.mean - 1), mean.half_width + 0.005) << int(influence);
        EXPECT_LE(mean.half_width, kMustDetect) << "too noisy to notice a defect";
    }
}

TEST(ReversePhotonMapping, MemoryIsEstimatedToAFewPercentAndBoundedByTiles) {
    const Scene scene = make_builtin_scene("cornell-box");
    for (const InfluenceRadius influence : {InfluenceRadius::Fixed, InfluenceRadius::Leaf}) {
        Reverse settings = reverse_settings();
        settings.params.photons = 100'000;
        settings.params.influence_radius = influence;
        MemoryBudget budget, many_rays;
        test::render(scene, settings, nullptr, &budget);
        const auto estimate =
            double(ReversePhotonMapping::estimate_bytes(settings.params, test::workload_of(scene, settings)));
        EXPECT_NEAR(estimate / double(budget.accounted_bytes()), 1, 0.05);

        settings.params.gather_rays = 256;
        test::render(scene, settings, nullptr, &many_rays);
        EXPECT_EQ(many_rays.structures().at("reverse_photons"), budget.structures().at("reverse_photons"));
    }
}

TEST(ReversePhotonMapping, RefusesWhatDoesNotFit) {
    Reverse settings = reverse_settings();
    settings.params.tile_points = 1 << 22;
    MemoryBudget budget(64 << 20);
    EXPECT_THROW(test::render(make_builtin_scene("cornell-box"), settings, nullptr, &budget), Error);
}

TEST(ReversePhotonMapping, RadiusInMetresAndRelativeRadiusExcludeEachOther) {
    ReversePhotonMappingParams params;
    params.radius_m = 0.1f;
    EXPECT_NO_THROW(params.check());
    params.radius_relative = 0.1f;
    EXPECT_THROW(params.check(), Error);
}

TEST(ReversePhotonMapping, StaysFiniteWhereThereIsNothingToWorkWith) {
    for (const test::HardScene& hard : test::hard_scenes()) {
        for (const InfluenceRadius influence : {InfluenceRadius::Fixed, InfluenceRadius::Knn, InfluenceRadius::Leaf}) {
            for (const uint32_t photons : {1u, 3000u}) {
                Reverse settings = reverse_settings();
                settings.size = {16, 16};
                settings.params.photons = photons;
                settings.params.gather_rays = 4;
                settings.params.tile_points = 1024;
                settings.params.influence_radius = influence;
                settings.params.boundary = photons == 1 ? DiscBoundary::Clip : DiscBoundary::None;
                SCOPED_TRACE(testing::Message()
                             << hard.name << ", " << photons << " photons, influence " << int(influence));
                const Film film = test::render(hard.scene, settings);
                EXPECT_EQ(film.nan_count(), 0u);
                EXPECT_EQ(film.infinity_count(), 0u);
                for (const float value : film.resolve_beauty()) EXPECT_GE(value, 0);
            }
        }
    }
}

TEST(ReversePhotonMapping, ACancelledPassLeavesNothing) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    MemoryBudget budget;
    Stats stats;
    const auto intersector = make_embree_intersector(scene, budget, stats);
    ReversePhotonMappingParams params;
    params.photons = 1000;
    params.gather_rays = 2;
    params.keep_photon_map = true;
    params.tile_points = 1024;
    ReversePhotonMapping method(params);
    method.begin({scene, intersector.get(), View{find_camera(scene, ""), {64, 64}}, 1, budget}, stats);
    Film film({64, 64}, {});
    CancelToken cancel;
    cancel.cancel();
    method.run_pass(0, stats, cancel);
    method.resolve(film);
    EXPECT_EQ(film.passes(), 0u);
    method.run_pass(0, stats, CancelToken{});
    method.resolve(film);
    EXPECT_EQ(film.passes(), 1u);
    ASSERT_EQ(method.artefacts().size(), 1u);
    EXPECT_EQ(method.artefacts()[0].name, "photon_map.glb");
}

}  // namespace
}  // namespace photond::reverse_photon_mapping_test
