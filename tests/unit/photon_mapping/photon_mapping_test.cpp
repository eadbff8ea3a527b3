// What photon mapping promises beside the right light: bits that do not depend on threads, layers, counts, skipped
// parts, parameters, memory; and that it stays finite in scenes that leave it nothing to work with.

#include "renderer/methods/photon_mapping/photon_mapping.h"

#include <gtest/gtest.h>

#include "protocol/error.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/hard_scenes.h"
#include "tests/support/path_render.h"
#include "tests/support/statistics.h"
#include "tests/support/threads.h"

namespace photond::photon_mapping_test {
namespace {

using Settings = test::RenderSettingsOf<PhotonMapping>;

Settings settings_for(Gather gather, uint32_t passes = 1) {
    Settings settings;
    settings.size = {40, 35};  // tiles cut at both edges
    settings.passes = passes;
    for (const Layer layer : {Layer::Caustic, Layer::Albedo, Layer::Normal, Layer::Position, Layer::Depth})
        settings.layers.add(layer);
    settings.params.photons = 2000;
    settings.params.gather = gather;
    settings.params.gather_rays = 8;
    settings.params.nearest_photons = 20;
    return settings;
}

const Skipped* find_skipped(const Stats& stats, std::string_view what) {
    for (const Skipped& skipped : stats.skipped)
        if (skipped.what == what) return &skipped;
    return nullptr;
}

double sum_of(const std::vector<float>& values) { return test::mean_of(values) * double(values.size()); }

void expect_sane(const Film& film) {
    EXPECT_EQ(film.nan_count(), 0u);
    EXPECT_EQ(film.infinity_count(), 0u);
    for (const float value : film.resolve_beauty()) EXPECT_GE(value, 0);
}

TEST(PhotonMapping, PixelHashIsTheSameForAnyNumberOfThreads) {
    for (const char* name : {"cornell-box", "cornell-box-glass", "cornell-box-glossy"}) {
        const Scene scene = make_builtin_scene(name);
        for (const Gather gather : {Gather::Direct, Gather::Final}) {
            Settings settings = settings_for(gather, 2);
            settings.params.shadow_photons = settings.params.precompute_irradiance = true;
            settings.params.gather_sampling = GatherSampling::Photons;
            std::vector<std::string> hashes;
            for (const int threads : {1, 2, 8})
                hashes.push_back(test::on_threads(threads, [&] { return test::render(scene, settings).pixel_hash(); }));
            EXPECT_EQ(hashes[0], hashes[1]) << name;
            EXPECT_EQ(hashes[0], hashes[2]) << name;
        }
    }
}

TEST(PhotonMapping, PrecomputesIrradianceWhereRaysAreManyEnough) {
    const Scene scene = make_builtin_scene("cornell-box");
    for (const uint32_t photons : {2000u, 200'000u}) {  // some 450 and 45,000 are marked, for 11,200 gather rays
        Settings settings = settings_for(Gather::Final);
        settings.params.photons = photons;
        Stats stats;
        test::render(scene, settings, &stats);
        EXPECT_EQ(find_skipped(stats, "precomputed irradiance") != nullptr, photons > 2000);
    }
}

TEST(PhotonMapping, APassIsAPureFunctionOfItsIndex) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    Settings settings = settings_for(Gather::Final);
    settings.first_pass = 5;
    const Film alone = test::render(scene, settings), again = test::render(scene, settings);
    EXPECT_EQ(alone, again);
    settings.first_pass = 6;
    EXPECT_NE(alone.pixel_hash(), test::render(scene, settings).pixel_hash());
    settings.first_pass = 5;
    settings.seed = 2;
    EXPECT_NE(alone.pixel_hash(), test::render(scene, settings).pixel_hash());
}

// Emitted and direct light are sampled, never looked up: they are path tracing's in the mean. Glossy floors, mirrors
// and glass take all parts of the split.
TEST(PhotonMapping, EmittedAndDirectLightAreThoseOfPathTracing) {
    constexpr double kFalseAlarm = 1e-6, kMustDetect = 0.02;
    const char* kScenes[] = {"cornell-box", "cornell-box-glossy", "cornell-box-glass"};
    for (const char* name : kScenes) {
        const Scene scene = make_builtin_scene(name);
        std::vector<double> emitted, direct;
        for (uint64_t seed = 1; seed <= 32; ++seed) {
            Settings settings = settings_for(Gather::Final, 16);
            settings.params.indirect_bounces = 1;  // so that there are gather rays, which meet lights
            settings.params.gather_rays = 2;
            settings.params.light_samples = 3;
            settings.params.photons = 1;
            settings.seed = seed;
            test::RenderSettings traced;
            traced.size = settings.size;
            traced.passes = settings.passes;
            traced.params.indirect_bounces = 0;
            traced.seed = seed;  // the same camera rays: that part of the noise is common
            const Film ours = test::render(scene, settings), theirs = test::render(scene, traced);
            const auto ratio = [&](Layer layer) {
                return test::mean_of(ours.resolve(layer)) / test::mean_of(theirs.resolve(layer)) - 1;
            };
            emitted.push_back(ratio(Layer::Emitted));
            direct.push_back(ratio(Layer::Direct));
        }
        for (const auto& difference : {emitted, direct}) {
            const test::Interval interval = test::mean_interval(difference, kFalseAlarm, 2 * std::size(kScenes));
            EXPECT_LE(std::abs(interval.mean), interval.half_width) << name;
            EXPECT_LE(interval.half_width, kMustDetect) << name << ": too noisy to notice a defect";
        }
    }
}

// One bounce with every lobe that is no delta taken for rough: no photon map is looked up, and final gathering is
// unbiased. Its rays end at lobes that need rays of their own to find the lamp.
TEST(PhotonMapping, OneBounceBetweenGlossySurfacesIsThatOfPathTracing) {
    constexpr double kFalseAlarm = 1e-6, kMustDetect = 0.04;
    const Scene scene = make_builtin_scene("cornell-box-glossy");
    std::vector<double> differences;
    for (uint64_t seed = 1; seed <= 32; ++seed) {
        Settings settings = settings_for(Gather::Final, 16);
        settings.params.indirect_bounces = 1;
        settings.params.glossy_threshold = 0;
        settings.params.gather_rays = 8;
        settings.seed = seed;
        test::RenderSettings traced;
        traced.size = settings.size;
        traced.passes = 64;
        traced.params.indirect_bounces = 1;
        traced.seed = seed;
        differences.push_back(test::mean_of(test::render(scene, settings).resolve(Layer::Indirect)) /
                                  test::mean_of(test::render(scene, traced).resolve(Layer::Indirect)) -
                              1);
    }
    const test::Interval interval = test::mean_interval(differences, kFalseAlarm, 1);
    std::printf("relative difference %.4f +- %.4f\n", interval.mean, interval.half_width);
    EXPECT_LE(std::abs(interval.mean), interval.half_width);
    EXPECT_LE(interval.half_width, kMustDetect) << "too noisy to notice a defect";
}

/// Each value of the direct layer over some passes with so many light samples.
std::vector<test::RunningMean> direct_light(const Scene& scene, SamplerKind sampler, uint32_t light_samples,
                                            uint32_t passes, uint64_t seed) {
    Settings settings = settings_for(Gather::Direct);
    settings.size = {80, 70};
    settings.params.indirect_bounces = 0;
    settings.params.sampler = sampler;
    settings.params.light_samples = light_samples;
    settings.seed = seed;
    std::vector<test::RunningMean> values;
    for (settings.first_pass = 0; settings.first_pass < passes; ++settings.first_pass) {
        const std::vector<float> direct = test::render(scene, settings).resolve(Layer::Direct);
        values.resize(direct.size());
        for (size_t i = 0; i < direct.size(); ++i) values[i].add(direct[i]);
    }
    return values;
}

// With independent numbers V(n) = A + B / n, A being what the pixel's points differ by. Whatever A and B are,
// V(1) - 5 V(4) + 4 V(16) is 0: were the samples of a vertex alike, or not divided by their number, it would not be.
TEST(PhotonMapping, VarianceOfDirectLightFallsWithTheNumberOfLightSamples) {
    constexpr double kFalseAlarm = 1e-6, kMustDetect = 0.1;
    const Scene scene = make_builtin_scene("cornell-box");
    // Where A is small, by passes of their own: away from edges.
    std::vector<uint8_t> smooth;
    for (const test::RunningMean& value : direct_light(scene, SamplerKind::Sobol, 64, 24, 1000))
        smooth.push_back(value.variance() < 0.001 * value.mean() * value.mean());
    EXPECT_GT(std::count(smooth.begin(), smooth.end(), 1), std::ptrdiff_t(smooth.size() / 4));
    const auto variance = [&](SamplerKind sampler, uint32_t light_samples, uint64_t seed) {
        const std::vector<test::RunningMean> values = direct_light(scene, sampler, light_samples, 4, seed);
        double sum = 0;
        for (size_t i = 0; i < values.size(); ++i)
            if (smooth[i]) sum += values[i].variance();
        return sum;
    };
    std::vector<double> one, sixteen, stratified, contrast;
    for (uint64_t seed = 1; seed <= 16; ++seed) {
        one.push_back(variance(SamplerKind::Random, 1, seed));
        sixteen.push_back(variance(SamplerKind::Random, 16, seed));
        stratified.push_back(variance(SamplerKind::Sobol, 16, seed));
        contrast.push_back(one.back() - 5 * variance(SamplerKind::Random, 4, seed) + 4 * sixteen.back());
    }
    const auto mean = [&](const std::vector<double>& x) { return test::mean_interval(x, kFalseAlarm, 1).mean; };
    const double scale = mean(one), of_sixteen = mean(sixteen), of_strata = mean(stratified);
    const test::Interval interval = test::mean_interval(contrast, kFalseAlarm, 1);
    std::printf("variance of 16 samples over that of 1: %.4f, stratified %.4f; contrast %.4f +- %.4f\n",
                of_sixteen / scale, of_strata / scale, interval.mean / scale, interval.half_width / scale);
    EXPECT_LE(std::abs(interval.mean), interval.half_width);
    EXPECT_LE(interval.half_width, kMustDetect * scale) << "too noisy to notice a defect";
    EXPECT_LT(of_sixteen, scale / 8);
    EXPECT_LT(of_strata, of_sixteen);
}

TEST(PhotonMapping, NoIndirectBouncesLeaveTheLayerBlackAndTraceNoPhotons) {
    for (const Gather gather : {Gather::Direct, Gather::Final}) {
        Settings settings = settings_for(gather);
        settings.params.indirect_bounces = 0;
        Stats stats;
        const Film film = test::render(make_builtin_scene("cornell-box-glass"), settings, &stats);
        EXPECT_EQ(sum_of(film.resolve(Layer::Indirect)), 0);
        EXPECT_EQ(sum_of(film.resolve(Layer::Caustic)), 0);
        EXPECT_GT(sum_of(film.resolve(Layer::Direct)), 0);
        EXPECT_EQ(stats.counts.photons_emitted, 0u);
        ASSERT_NE(find_skipped(stats, "global map"), nullptr);
        ASSERT_NE(find_skipped(stats, "caustic map"), nullptr);
        EXPECT_GT(find_skipped(stats, "global map")->bytes_saved, 0u);
    }
}

TEST(PhotonMapping, OneBounceOfFinalGatheringNeedsNoGlobalMap) {
    const Scene scene = make_builtin_scene("cornell-box");
    Settings settings = settings_for(Gather::Final);
    settings.params.indirect_bounces = 1;
    Stats stats;
    const Film film = test::render(scene, settings, &stats);
    EXPECT_GT(sum_of(film.resolve(Layer::Indirect)), 0);
    EXPECT_EQ(stats.counts.photons_emitted, 0u);
    ASSERT_NE(find_skipped(stats, "global map"), nullptr);

    Stats looked_up;
    settings.params.gather = Gather::Direct;
    const Film direct = test::render(scene, settings, &looked_up);
    EXPECT_GT(sum_of(direct.resolve(Layer::Indirect)), 0);
    EXPECT_EQ(looked_up.counts.photons_emitted, 2000u);
    EXPECT_EQ(find_skipped(looked_up, "global map"), nullptr);
}

TEST(PhotonMapping, WhatTheSceneDoesNotNeedIsSkipped) {
    Stats plain;
    test::render(make_builtin_scene("cornell-box"), settings_for(Gather::Final), &plain);
    ASSERT_NE(find_skipped(plain, "caustic map"), nullptr);
    EXPECT_EQ(find_skipped(plain, "caustic map")->why, "no specular surface");
    EXPECT_GT(find_skipped(plain, "caustic map")->bytes_saved, 0u);
    EXPECT_EQ(find_skipped(plain, "global map"), nullptr);
    EXPECT_EQ(plain.counts.photons_emitted, 2000u);

    Stats glass;
    Settings settings = settings_for(Gather::Final);
    settings.params.caustic_photons = 500;
    const Film film = test::render(make_builtin_scene("caustic-ring"), settings, &glass);
    EXPECT_EQ(find_skipped(glass, "caustic map"), nullptr);
    EXPECT_EQ(glass.counts.photons_emitted, 2500u);
    EXPECT_GT(sum_of(film.resolve(Layer::Caustic)), 0);
    const std::vector<float> caustic = film.resolve(Layer::Caustic), indirect = film.resolve(Layer::Indirect);
    for (size_t i = 0; i < caustic.size(); ++i) EXPECT_LE(caustic[i], indirect[i] * 1.00001f);
}

TEST(PhotonMapping, CountsStagesAndMemoryAreReported) {
    const Scene scene = make_builtin_scene("cornell-box");
    Settings settings = settings_for(Gather::Final, 2);
    settings.layers.add(Layer::PhotonCount);
    Stats stats;
    MemoryBudget budget;
    const Film film = test::render(scene, settings, &stats, &budget);
    const uint64_t pixels = settings.size.pixels();
    EXPECT_EQ(stats.counts.camera_rays, 2 * pixels);
    EXPECT_EQ(stats.counts.photons_emitted, 2 * 2000u);
    EXPECT_GT(stats.counts.photons_stored, 0u);
    EXPECT_GT(stats.counts.photon_rays, stats.counts.photons_emitted);
    EXPECT_LE(stats.counts.bounce_rays, 2 * pixels * *settings.params.gather_rays);
    EXPECT_GT(stats.counts.bounce_rays, pixels * *settings.params.gather_rays);
    EXPECT_GT(stats.counts.shadow_rays, stats.counts.bounce_rays / 4);
    EXPECT_GT(sum_of(film.resolve(Layer::PhotonCount)), double(pixels));
    for (const char* stage : {"photon_tracing", "photon_map_build", "g_buffer", "direct", "gather"})
        EXPECT_GT(stats.stage(stage).cpu_seconds, 0) << stage;
    for (const char* structure : {"pass_image", "wavefronts", "light_sampler", "emission_sampler", "global_map"})
        EXPECT_GT(budget.structures().at(structure), 0u) << structure;
}

// A pass counts its own photons: the k - 1 that a nearest search in a well filled map finds, once a pixel.
TEST(PhotonMapping, PhotonCountIsThatOfOnePass) {
    Settings settings = settings_for(Gather::Direct, 3);
    settings.layers.add(Layer::PhotonCount);
    settings.params.photons = 50'000;
    const Film film = test::render(make_builtin_scene("cornell-box"), settings);
    const std::vector<float> count = film.resolve(Layer::PhotonCount);
    EXPECT_LE(*std::max_element(count.begin(), count.end()), float(settings.params.nearest_photons - 1));
    EXPECT_GT(test::mean_of(count), 0.7 * (settings.params.nearest_photons - 1));
}

TEST(PhotonMapping, MemoryIsEstimatedToAFewPercentForPlainScenes) {
    const Scene scene = make_builtin_scene("cornell-box");
    for (const Gather gather : {Gather::Direct, Gather::Final}) {
        Settings settings = settings_for(gather);
        settings.params.photons = 100'000;
        settings.params.gather_rays = 1;
        MemoryBudget budget;
        test::render(scene, settings, nullptr, &budget);
        const auto estimate =
            double(PhotonMapping::estimate_bytes(settings.params, test::workload_of(scene, settings)));
        EXPECT_NEAR(estimate / double(budget.accounted_bytes()), 1, 0.05);
    }
}

// A pass's maps take the place of the last one's.
TEST(PhotonMapping, WhatFitsOnceFitsInEveryPass) {
    const Scene scene = make_builtin_scene("cornell-box");
    Settings settings = settings_for(Gather::Direct);
    settings.params.photons = 100'000;
    MemoryBudget once;
    test::render(scene, settings, nullptr, &once);
    MemoryBudget tight(once.accounted_bytes() * 105 / 100);
    settings.passes = 3;
    EXPECT_NO_THROW(test::render(scene, settings, nullptr, &tight));
}

TEST(PhotonMapping, RefusesWhatDoesNotFit) {
    Settings settings = settings_for(Gather::Final);
    settings.params.photons = 10'000'000;
    MemoryBudget budget(32 << 20);
    EXPECT_THROW(test::render(make_builtin_scene("cornell-box"), settings, nullptr, &budget), Error);
}

TEST(PhotonMapping, RadiusInMetresAndRelativeRadiusExcludeEachOther) {
    PhotonMappingParams params;
    params.radius_m = 0.1f;
    EXPECT_NO_THROW(params.check());
    EXPECT_EQ(params.search_radius_m(7), 0.1f);
    params.radius_relative = 0.1f;
    try {
        params.check();
        FAIL() << "both radii were taken";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::Conflict);
        ASSERT_EQ(error.faults.size(), 1u);
        EXPECT_EQ(error.faults[0].pointer, "/radius_relative");
    }
    params.radius_m.reset();
    EXPECT_NO_THROW(params.check());
    EXPECT_FLOAT_EQ(params.search_radius_m(7), 0.7f);
}

TEST(PhotonMapping, AutomaticGatherRaysAreAsManyAPassWhateverTheImagesSize) {
    const auto expect_splits = [](const PhotonMappingParams& params, Size2 size, uint32_t lights, uint32_t rays) {
        const Splits splits = params.splits(size.pixels());
        EXPECT_EQ(splits.light_samples, lights) << size.width << " x " << size.height;
        EXPECT_EQ(splits.gather_rays, rays) << size.width << " x " << size.height;
    };
    PhotonMappingParams params;
    expect_splits(params, {1, 1}, 2, 8);
    expect_splits(params, {512, 256}, 2, 8);
    expect_splits(params, {512, 257}, 1, 7);
    expect_splits(params, {512, 512}, 1, 4);
    expect_splits(params, {16384, 16384}, 1, 1);
    params.gather_rays = 64;
    expect_splits(params, {512, 512}, 16, 64);
    params.light_samples = 3;
    expect_splits(params, {512, 512}, 3, 64);
    params.gather = Gather::Direct;
    expect_splits(params, {512, 512}, 3, 0);
    params.light_samples.reset();
    expect_splits(params, {512, 512}, 1, 0);
}

TEST(PhotonMapping, ACancelledPassLeavesNothing) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    MemoryBudget budget;
    Stats stats;
    const auto intersector = make_embree_intersector(scene, budget, stats);
    PhotonMappingParams params;
    params.photons = 1000;
    params.gather_rays = 2;
    params.keep_photon_map = true;
    PhotonMapping method(params);
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
    // The photons of the last whole pass outlive a cancelled one.
    method.run_pass(1, stats, cancel);
    method.resolve(film);
    EXPECT_EQ(film.passes(), 1u);
    ASSERT_EQ(method.artefacts().size(), 1u);
    EXPECT_EQ(method.artefacts()[0].name, "photon_map.glb");
}

TEST(PhotonMapping, StaysFiniteWhereThereIsNothingToWorkWith) {
    for (const test::HardScene& hard : test::hard_scenes()) {
        for (const Gather gather : {Gather::Direct, Gather::Final}) {
            for (const uint32_t photons : {1u, 3000u}) {
                for (const bool options : {false, true}) {
                    Settings settings = settings_for(gather);
                    settings.size = {16, 16};
                    settings.params.photons = photons;
                    settings.params.search = options ? PhotonSearch::Kind::Radius : PhotonSearch::Kind::Nearest;
                    settings.params.boundary = options ? DiscBoundary::Clip : DiscBoundary::None;
                    settings.params.gather_sampling = options ? GatherSampling::Photons : GatherSampling::Bsdf;
                    settings.params.precompute_irradiance = settings.params.shadow_photons = options;
                    settings.layers.add(Layer::PhotonCount);
                    SCOPED_TRACE(testing::Message() << hard.name << ", " << photons << " photons, gather "
                                                    << int(gather) << ", options " << options);
                    const Film film = test::render(hard.scene, settings);
                    expect_sane(film);
                    EXPECT_EQ(sum_of(film.resolve_beauty()) == 0, hard.dark);
                }
            }
        }
    }
}

}  // namespace
}  // namespace photond::photon_mapping_test
