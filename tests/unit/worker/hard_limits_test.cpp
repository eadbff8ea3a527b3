// The hard cases that no scene can show (renderer/scene/hard_cases.h): very many passes, very many photons in one
// place, hardly any photons, frame after frame.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "protocol/error.h"
#include "protocol/param_json.h"
#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/photons/hash_grid.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/mesh_builder.h"
#include "server/worker/scene_cache.h"
#include "tests/support/path_render.h"
#include "tests/support/scene_parts.h"
#include "tests/support/test_gltf.h"

namespace photond::hard_limits_test {
namespace {

constexpr uint32_t kMillion = 1u << 20;

// A million passes of a constant: the sums are exact, so nothing can drift, however the passes are shared out.
TEST(HardLimits, AMillionPassesOfAConstantAreThatConstant) {
    constexpr float kValue = 0.1f, kNearlyTheLimit = 0.99f * kFilmValueLimit;
    Film whole({2, 1}, LayerSet());
    Film parts[] = {Film({2, 1}, LayerSet()), Film({2, 1}, LayerSet(), kMillion / 4)};
    PassImage pass({2, 1}, LayerSet());
    pass.of<Layer::Indirect>() = {Rgb(kValue), Rgb(kNearlyTheLimit)};
    for (uint32_t i = 0; i < kMillion; ++i) {
        whole.add_pass(pass);
        parts[i < kMillion / 4 ? 0 : 1].add_pass(pass);
    }
    parts[1].merge(parts[0]);
    EXPECT_EQ(whole.passes(), kMillion);
    EXPECT_EQ(whole.infinity_count(), 0u);
    EXPECT_EQ(parts[1].pixel_hash(), whole.pixel_hash());
    const std::vector<float> mean = whole.resolve(Layer::Indirect), variance = whole.pass_variance(Layer::Indirect);
    for (size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(mean[c], kValue, 1e-6 * double(kValue));
        EXPECT_NEAR(mean[3 + c], kNearlyTheLimit, 1e-6 * double(kNearlyTheLimit));
        EXPECT_LE(variance[c], sqr(1e-6f * kValue));
    }
}

// Alternating values: the variance between passes is exact too, p (1 - p) d^2 with the unbiased n / (n - 1).
TEST(HardLimits, AMillionPassesKeepTheVariance) {
    Film film({1, 1}, LayerSet());
    PassImage dark({1, 1}, LayerSet()), bright = dark;
    dark.of<Layer::Indirect>() = {Rgb(1.0f)};
    bright.of<Layer::Indirect>() = {Rgb(1.0f + 0x1p-10f)};
    for (uint32_t i = 0; i < kMillion; ++i) film.add_pass(i % 2 ? bright : dark);
    constexpr double kExact = 0.25 * 0x1p-20 * kMillion / (kMillion - 1.0);
    EXPECT_NEAR(film.pass_variance(Layer::Indirect)[0], kExact, 1e-6 * kExact);
}

// 1e8 photons in one pixel of each of a thousand passes: 1e11 in all, more than 32 bits count.
TEST(HardLimits, AHundredMillionPhotonsInAPixelKeepTheirMean) {
    constexpr float kPhotons = 1e8f;
    LayerSet layers;
    layers.add(Layer::PhotonCount);
    Film film({1, 1}, layers);
    PassImage pass({1, 1}, layers);
    pass.of<Layer::PhotonCount>() = {kPhotons};
    pass.hit = {1};
    for (int i = 0; i < 1000; ++i) film.add_pass(pass);
    EXPECT_EQ(film.infinity_count(), 0u);
    EXPECT_NEAR(film.resolve(Layer::PhotonCount)[0], kPhotons, 1e-6 * double(kPhotons));
}

TEST(HardLimits, AMillionPhotonsAtOnePointAreAllFound) {
    const std::vector<vec3> points(kMillion, vec3(0.3f, 0.2f, 0.1f));
    std::vector<uint32_t> order(points.size());
    Neighbours found;
    HashGrid(points, 0.01f, order).find_within(points[0], 0.01f, found);
    EXPECT_EQ(found.found.size(), kMillion);
}

TEST(HardLimits, OnePhotonIsDefinedAndNoPhotonsAreRefused) {
    for (const char* name : {"cornell-box", "hard-case/all-mirror", "hard-case/no-light", "hard-case/dark-box"})
        for (uint64_t seed = 1; seed <= 4; ++seed) {
            test::RenderSettingsOf<PhotonMapping> settings;
            settings.size = {8, 8};
            settings.seed = seed;
            settings.passes = 2;
            settings.params.photons = 1;
            const Film film = test::render(make_builtin_scene(name), settings);
            EXPECT_EQ(film.nan_count() + film.infinity_count(), 0u) << name;
            for (const float value : film.resolve_beauty()) ASSERT_TRUE(value >= 0 && std::isfinite(value)) << name;
        }
    PhotonMappingParams params;
    std::vector<Fault> faults;
    read_params(params, {{"photons", 0}}, "", faults);
    ASSERT_EQ(faults.size(), 1u);
    EXPECT_EQ(faults[0].pointer, "/photons");
}

/// A frame of an animation: a thin plate before a lit wall, at x.
Scene plate_at(float x) {
    Scene scene;
    test::add(scene, MeshBuilder().quad({-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}).build(0), test::lambert(0.5f));
    test::add(scene, MeshBuilder().box({x, -1, 0.5f}, {x + 0.001f, 1, 1}).build(0), test::lambert(0.8f));
    test::add(scene, MeshBuilder().quad({-1, 2, 1}, {1, 2, 1}, {1, 1, 2}, {-1, 1, 2}).build(0), test::emitting(Rgb(5)));
    scene.cameras.push_back(look_at_camera({0.2, 0.1, 4}, {0, 0, 0}, {0, 1, 0}, 0.7f));
    finish_scene(scene);
    return scene;
}

template <class M>
void expect_frames_to_stand_alone() {
    test::RenderSettingsOf<M> settings;
    settings.size = {16, 16};
    if constexpr (std::is_same_v<M, PhotonMapping>) settings.params.photons = 500;
    const std::vector<float> places{-0.5f, 0.0f, 0.5f};
    std::vector<std::string> alone;
    for (const float x : places) alone.push_back(test::render(plate_at(x), settings).pixel_hash());
    EXPECT_NE(alone[0], alone[1]);
    // Frame after frame in one place in memory, as an animation would have it, there and back.
    Scene frame;
    for (const size_t i : {size_t{0}, size_t{1}, size_t{2}, size_t{1}, size_t{0}}) {
        frame = plate_at(places[i]);
        EXPECT_EQ(test::render(frame, settings).pixel_hash(), alone[i]) << "frame " << i;
    }
}

TEST(HardLimits, FramesOfAThinObjectStandAlone) {
    expect_frames_to_stand_alone<PathTracing>();
    expect_frames_to_stand_alone<PhotonMapping>();
}

}  // namespace
}  // namespace photond::hard_limits_test
