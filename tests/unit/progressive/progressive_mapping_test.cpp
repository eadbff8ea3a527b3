// What the progressive photon mapping methods promise beside the right light: bits that depend neither on threads nor
// on where passes are rendered, state that goes on, layers, skipped parts, parameters, memory.

#include "renderer/progressive/progressive_mapping.h"

#include <gtest/gtest.h>

#include "protocol/error.h"
#include "renderer/methods/probabilistic_progressive_photon_mapping/probabilistic_progressive_photon_mapping.h"
#include "renderer/methods/progressive_photon_mapping/progressive_photon_mapping.h"
#include "renderer/methods/registry.h"
#include "renderer/methods/stochastic_progressive_photon_mapping/stochastic_progressive_photon_mapping.h"
#include "renderer/photons/photon_map.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/hard_scenes.h"
#include "tests/support/render.h"
#include "tests/support/threads.h"

namespace photond::progressive_mapping_test {
namespace {

using Fixed = ProgressivePhotonMapping;
using Stochastic = StochasticProgressivePhotonMapping;
using Probabilistic = ProbabilisticProgressivePhotonMapping;

template <class M>
test::RenderSettingsOf<M> settings_for(RadiusRule rule, uint32_t passes) {
    test::RenderSettingsOf<M> settings;
    settings.size = {40, 35};  // tiles cut at both edges
    settings.passes = passes;
    settings.params.radius_rule = rule;
    settings.params.photons = 2000;
    settings.params.nearest_photons = 20;
    return settings;
}

/// A film of passes of which each may go on from the one before in a run of its own.
template <class M>
Film go_on(const Scene& scene, test::RenderSettingsOf<M> settings, const std::vector<uint32_t>& lengths) {
    Film film(settings.size, settings.layers, settings.first_pass);
    std::string state;
    for (const uint32_t length : lengths) {
        MemoryBudget budget;
        Stats stats;
        const std::unique_ptr<Intersector> intersector = make_embree_intersector(scene, budget, stats);
        const RenderContext context{scene, intersector.get(), test::view_of(scene, settings), settings.seed, budget};
        M method(settings.params);
        if (film.passes() > 0) method.go_on_from(state);
        method.begin(context, stats);
        for (uint32_t i = 0; i < length; ++i) {
            method.run_pass(film.next_pass(), stats, CancelToken{});
            method.resolve(film);
        }
        state = method.state();
    }
    return film;
}

template <class M>
void expect_the_same_for_any_number_of_threads(RadiusRule rule) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    auto settings = settings_for<M>(rule, 3);
    for (const Layer layer : {Layer::Caustic, Layer::PhotonCount, Layer::Radius, Layer::BiasEstimate})
        settings.layers.add(layer);
    std::vector<std::string> hashes;
    for (const int threads : {1, 2, 8})
        hashes.push_back(test::on_threads(threads, [&] { return test::render(scene, settings).pixel_hash(); }));
    EXPECT_EQ(hashes[0], hashes[1]);
    EXPECT_EQ(hashes[0], hashes[2]);
}

TEST(ProgressiveMapping, PixelHashIsTheSameForAnyNumberOfThreads) {
    expect_the_same_for_any_number_of_threads<Fixed>(RadiusRule::Local);
    expect_the_same_for_any_number_of_threads<Stochastic>(RadiusRule::Tested);
    expect_the_same_for_any_number_of_threads<Probabilistic>(RadiusRule::Global);
    expect_the_same_for_any_number_of_threads<Probabilistic>(RadiusRule::Trained);
}

TEST(ProgressiveMapping, RunsThatGoOnMakeTheSameBits) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    for (const RadiusRule rule : {RadiusRule::Global, RadiusRule::Trained, RadiusRule::Local, RadiusRule::Tested}) {
        const auto settings = settings_for<Stochastic>(rule, 6);
        EXPECT_EQ(go_on(scene, settings, {1, 3, 2}), go_on(scene, settings, {6})) << int(rule);
        auto by_sectors = settings;
        by_sectors.params.test = CurvatureTest::Sector;
        EXPECT_EQ(go_on(scene, by_sectors, {4, 2}), go_on(scene, by_sectors, {6})) << int(rule);
        auto fixed = settings_for<Fixed>(rule, 6);
        fixed.params.eye_samples = 4;  // sets of hit points begun and not begun
        EXPECT_EQ(go_on(scene, fixed, {2, 4}), go_on(scene, fixed, {6})) << int(rule);
    }
}

TEST(ProgressiveMapping, WithoutItsStateARunMakesOtherBits) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    auto settings = settings_for<Stochastic>(RadiusRule::Local, 2);
    const Film whole = go_on(scene, settings, {2});
    const auto in_parts = [&](auto part) {
        part.passes = 1;
        Film film = test::render(scene, part);
        part.first_pass = 1;
        film.merge(test::render(scene, part));
        return film.pixel_hash();
    };
    EXPECT_NE(in_parts(settings), whole.pixel_hash());
    const auto alone = settings_for<Stochastic>(RadiusRule::Trained, 2);
    EXPECT_EQ(in_parts(alone), test::render(scene, alone).pixel_hash()) << "its passes stand alone";
}

TEST(ProgressiveMapping, AStateOfAnotherRenderIsRefused) {
    const Scene scene = make_builtin_scene("cornell-box");
    const auto settings = settings_for<Stochastic>(RadiusRule::Local, 1);
    MemoryBudget budget;
    Stats stats;
    const std::unique_ptr<Intersector> intersector = make_embree_intersector(scene, budget, stats);
    const auto begin_from = [&](const std::string& state, Size2 size) {
        auto other = settings;
        other.size = size;
        const RenderContext context{scene, intersector.get(), test::view_of(scene, other), 1, budget};
        Stochastic method(settings.params);
        method.go_on_from(state);
        method.begin(context, stats);
        return method.state();
    };
    EXPECT_THROW(begin_from("", settings.size), Error) << "without radii";
    Stochastic fresh(settings.params);
    const RenderContext context{scene, intersector.get(), test::view_of(scene, settings), 1, budget};
    fresh.begin(context, stats);
    const std::string state = fresh.state();
    EXPECT_EQ(begin_from(state, settings.size), state);
    EXPECT_THROW(begin_from(state, {41, 35}), Error);
    EXPECT_THROW(begin_from(state.substr(0, state.size() - 1), settings.size), Error);
    Probabilistic alone{Probabilistic::Params()};
    EXPECT_THROW(alone.go_on_from(state), Error);
    EXPECT_NO_THROW(alone.go_on_from(""));
}

TEST(ProgressiveMapping, ACancelledPassLeavesRadiiAsTheyWere) {
    const Scene scene = make_builtin_scene("cornell-box");
    const auto settings = settings_for<Stochastic>(RadiusRule::Local, 1);
    MemoryBudget budget;
    Stats stats;
    const std::unique_ptr<Intersector> intersector = make_embree_intersector(scene, budget, stats);
    const RenderContext context{scene, intersector.get(), test::view_of(scene, settings), 1, budget};
    Stochastic method(settings.params);
    method.begin(context, stats);
    Film film(settings.size, settings.layers);
    method.run_pass(0, stats, CancelToken{});
    method.resolve(film);
    const std::string state = method.state();
    method.run_pass(1, stats, CancelToken{});  // whole, but never part of the image
    EXPECT_EQ(method.state(), state);
    CancelToken cancelled;
    cancelled.cancel();
    method.run_pass(1, stats, cancelled);
    method.resolve(film);
    EXPECT_EQ(film.passes(), 1u);
    EXPECT_EQ(method.state(), state);
    method.run_pass(1, stats, CancelToken{});
    method.resolve(film);
    EXPECT_NE(method.state(), state);
}

TEST(ProgressiveMapping, RadiiShrinkByTheirRule) {
    const Scene scene = make_builtin_scene("cornell-box");
    const auto radii = [&](auto settings, uint32_t first, uint32_t passes) {
        settings.layers.add(Layer::Radius);
        settings.first_pass = first, settings.passes = passes;
        return test::render(scene, settings).resolve(Layer::Radius);
    };
    auto global = settings_for<Probabilistic>(RadiusRule::Global, 1);
    global.params.radius_m = 0.1f;
    global.params.alpha = 0.5f;
    const auto expect_all = [](const std::vector<float>& values_m, float expected_m) {
        for (const float radius_m : values_m) EXPECT_TRUE(radius_m == 0 || std::abs(radius_m - expected_m) < 1e-6f);
    };
    expect_all(radii(global, 0, 1), 0.1f);
    // r_3^2 = r_1^2 (1 + alpha)/2 (2 + alpha)/3
    expect_all(radii(global, 2, 1), 0.1f * std::sqrt(1.5f / 2 * 2.5f / 3));

    auto local = settings_for<Stochastic>(RadiusRule::Local, 1);
    local.params.radius_m = 0.1f;
    local.params.alpha = 0.5f;
    local.params.photons = 10'000;
    local.layers.add(Layer::PhotonCount);
    local.layers.add(Layer::Radius);
    const std::vector<float> counted = go_on(scene, local, {1}).resolve(Layer::PhotonCount);
    const std::vector<float> mean_m = go_on(scene, local, {2}).resolve(Layer::Radius);
    size_t shrunk = 0, kept = 0;
    for (size_t y = 20; y < 32; ++y)  // the lower half of the room, where every path meets a matte surface
        for (size_t x = 8; x < 32; ++x) {
            const size_t i = y * local.size.width + x;
            // N = 0 before: r^2 <- alpha r^2 where the first pass counted any photon.
            const float second_m = counted[i] > 0 ? 0.1f * std::sqrt(0.5f) : 0.1f;
            ++(counted[i] > 0 ? shrunk : kept);
            EXPECT_NEAR(mean_m[i], 0.5f * (0.1f + second_m), 1e-6f) << x << ", " << y;
        }
    EXPECT_GT(shrunk, 100u);
    EXPECT_GT(kept, 1u);
}

TEST(ProgressiveMapping, WhatASceneDoesNotNeedIsSkipped) {
    Stats stats;
    test::render(make_builtin_scene("cornell-box"), settings_for<Probabilistic>(RadiusRule::Trained, 1), &stats);
    const auto skipped = [&](std::string_view what) {
        for (const Skipped& part : stats.skipped)
            if (part.what == what) return part.why;
        return std::string();
    };
    EXPECT_EQ(skipped("caustic map"), "no specular surface");
    EXPECT_EQ(skipped("global map"), "");

    auto direct = settings_for<Stochastic>(RadiusRule::Local, 1);
    direct.params.indirect_bounces = 0;
    stats = {};
    const Film film = test::render(make_builtin_scene("cornell-box-glass"), direct, &stats);
    EXPECT_EQ(skipped("global map"), "indirect_bounces is 0");
    EXPECT_EQ(skipped("caustic map"), "indirect_bounces is 0");
    EXPECT_EQ(stats.counts.photons_emitted, 0u);
    EXPECT_EQ(test::mean_of(film.resolve(Layer::Indirect)), 0);
    EXPECT_GT(test::mean_of(film.resolve(Layer::Direct)), 0);
}

TEST(ProgressiveMapping, ParametersThatExcludeEachOtherAreRefused) {
    const auto fault_of = [](const ProgressiveParams& params) {
        try {
            params.check();
        } catch (const Error& error) {
            return error.faults.at(0).pointer;
        }
        return std::string();
    };
    Stochastic::Params params;
    EXPECT_EQ(fault_of(params), "");
    params.radius_m = 0.1f;
    EXPECT_EQ(fault_of(params), "");
    params.radius_relative = 0.1f;
    EXPECT_EQ(fault_of(params), "/radius_relative");
    params = {};
    params.radius_rule = RadiusRule::Trained;
    params.radius_relative = 0.1f;
    EXPECT_EQ(fault_of(params), "/radius_relative");
    Probabilistic::Params alone;
    EXPECT_EQ(fault_of(alone), "");
    alone.radius_rule = RadiusRule::Local;
    EXPECT_EQ(fault_of(alone), "/radius_rule");
}

template <class M>
void expect_memory_as_estimated(RadiusRule rule) {
    const Scene scene = make_builtin_scene("cornell-box");
    auto settings = settings_for<M>(rule, 1);
    settings.size = {128, 128};
    settings.params.photons = 100'000;
    MemoryBudget budget;
    test::render(scene, settings, nullptr, &budget);
    const auto estimate = double(M::estimate_bytes(settings.params, test::workload_of(scene, settings)));
    const auto recorded = double(budget.accounted_bytes());
    if (rule == RadiusRule::Trained) {  // most of it is gone before the first pass
        EXPECT_GT(estimate, recorded);
        EXPECT_LT(estimate, recorded + double(PhotonMap::bytes_for(4 * 100'000)));
    } else {
        EXPECT_NEAR(estimate / recorded, 1, 0.05) << "rule " << int(rule);
    }
}

TEST(ProgressiveMapping, MemoryIsEstimatedToAFewPercentForPlainScenes) {
    for (const RadiusRule rule : {RadiusRule::Global, RadiusRule::Trained, RadiusRule::Local, RadiusRule::Tested}) {
        expect_memory_as_estimated<Stochastic>(rule);
        expect_memory_as_estimated<Fixed>(rule);
    }
}

TEST(ProgressiveMapping, TheRegistrySaysWhosePassesStandAlone) {
    const auto info = [](const char* name) {
        const MethodInfo* method = find_method(name);
        EXPECT_NE(method, nullptr) << name;
        return method;
    };
    EXPECT_FALSE(info("progressive_photon_mapping")->mergeable);
    EXPECT_FALSE(info("stochastic_progressive_photon_mapping")->mergeable);
    EXPECT_TRUE(info("probabilistic_progressive_photon_mapping")->mergeable);
    const MethodInfo* stochastic = info("stochastic_progressive_photon_mapping");
    Stochastic::Params params;
    params.radius_rule = RadiusRule::Trained;
    EXPECT_TRUE(stochastic->passes_stand_alone(params));
    params.radius_rule = RadiusRule::Tested;
    EXPECT_FALSE(stochastic->passes_stand_alone(params));
}

TEST(ProgressiveMapping, StaysFiniteInScenesThatLeaveItNothing) {
    for (const test::HardScene& hard : test::hard_scenes()) {
        const char* name = hard.name;
        const Scene& scene = hard.scene;
        const Film film = test::render(scene, settings_for<Stochastic>(RadiusRule::Tested, 2));
        EXPECT_EQ(film.nan_count() + film.infinity_count(), 0u) << name;
        for (const float value : film.resolve_beauty()) EXPECT_GE(value, 0) << name;
        const Film trained = test::render(scene, settings_for<Probabilistic>(RadiusRule::Trained, 1));
        EXPECT_EQ(trained.nan_count() + trained.infinity_count(), 0u) << name;
    }
}

}  // namespace
}  // namespace photond::progressive_mapping_test
