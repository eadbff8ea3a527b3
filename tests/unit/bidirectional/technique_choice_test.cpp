// The choice of techniques by a pilot: what the moments of candidates come to, that a simple scene gets no more than
// paths from the eye and a hard one does, and that the choice is a function of the seed alone.

#include "renderer/bidirectional/technique_pilot.h"

#include <gtest/gtest.h>

#include "renderer/methods/bidirectional_path_tracing/bidirectional_path_tracing.h"
#include "renderer/methods/path_tracing/path_tracing.h"
#include "renderer/methods/vertex_connection_and_merging/vertex_connection_and_merging.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/path_render.h"
#include "tests/support/threads.h"

namespace photond::technique_choice_test {
namespace {

// Two candidates: as the pilot, and with a quarter of its light paths.
const WeighedCandidate kAsPilot{.more_light_paths = 1, .more_connections = 1},
    kQuarter{.more_light_paths = 4, .more_connections = 1};

constexpr CandidateWeight kUnweighed{.weight = 1};

TEST(TechniqueChoice, WhatTheCameraSeesVariesAsCountsDo) {
    PixelMoments as_pilot, quarter;
    for (int i = 0; i < 8; ++i) as_pilot.add_seen(Rgb(2), kUnweighed), quarter.add_seen(Rgb(1), kUnweighed);
    EXPECT_DOUBLE_EQ(as_pilot.mean(4), 4);
    EXPECT_DOUBLE_EQ(as_pilot.variance(4, kAsPilot), 8);
    EXPECT_DOUBLE_EQ(quarter.mean(4), 2);
    EXPECT_DOUBLE_EQ(quarter.variance(4, kQuarter), 8);
}

TEST(TechniqueChoice, APathsSamplesVaryTogether) {
    // Four vertices merge in each pass, all worth the same: the eye's path tells what they are worth, 1 or 3.
    PixelMoments as_pilot, quarter;
    for (const float worth : {1.0f, 3.0f}) {
        EyePathSum path;
        for (int i = 0; i < 4; ++i) path.add(TechniqueKind::Merge, Rgb(worth), kUnweighed);
        as_pilot.add(path), quarter.add(path);
    }
    EXPECT_DOUBLE_EQ(as_pilot.mean(2), 8);
    EXPECT_DOUBLE_EQ(as_pilot.variance(2, kAsPilot), 32);  // of 4 and 12
    // One of each four is taken, for four times as much: 4 w^2 (4 - 1) more, on average 60.
    EXPECT_DOUBLE_EQ(quarter.variance(2, kQuarter), 32 + 60);
    // Without noise there is no variance, whatever the image is.
    PixelMoments same;
    for (int pass = 0; pass < 4; ++pass) {
        EyePathSum path;
        path.add(TechniqueKind::Alone, Rgb(3), kUnweighed);
        path.add(TechniqueKind::Connection, Rgb(2), kUnweighed);
        same.add(path);
    }
    EXPECT_DOUBLE_EQ(same.variance(4, kQuarter), 0);
    EXPECT_DOUBLE_EQ(same.variance(4, {.more_light_paths = 1, .more_connections = 0.125f}), 0);
}

// Light that merging finds a thousand times as often as the eye alone does: without merging the second moment is a
// thousand times what it is, though all that the pilot found of it would not be there.
TEST(TechniqueChoice, WhatACandidateLacksIsNotFree) {
    constexpr uint32_t kPasses = 4;
    const MisShare of_pilot{.own = 1000, .others = 1};
    const CandidateWeight with = weigh_candidate(of_pilot, of_pilot),
                          without = weigh_candidate(of_pilot, {.own = 0, .others = 1});
    EXPECT_FLOAT_EQ(with.weight, 1000.0f / 1001);
    EXPECT_EQ(without.weight, 0);
    EXPECT_NEAR(without.by_density / with.by_density, 1001, 0.01);
    PixelMoments merging, alone;
    for (uint32_t pass = 0; pass < kPasses; ++pass) {
        EyePathSum merged, missed;
        merged.add(TechniqueKind::Merge, Rgb(3), with);
        missed.add(TechniqueKind::Merge, Rgb(3), without);
        merging.add(merged), alone.add(missed);
    }
    EXPECT_NEAR(merging.second_moment(kPasses), 9 * 1000.0 * 1000 / (1001.0 * 1001), 1e-4);
    EXPECT_NEAR(alone.second_moment(kPasses), 1001 * merging.second_moment(kPasses), 1);
    VarianceSums sums(2);
    sums.of_paths = {merging.variance(kPasses, kAsPilot), alone.variance(kPasses, {})};
    sums.second_moments = {merging.second_moment(kPasses), alone.second_moment(kPasses)};
    EXPECT_NEAR(sums.of_paths[1], 0, 1e-6);  // as far as its own samples tell
    EXPECT_NEAR(sums.variances(0)[1], sums.of_paths[0] + 1000 * sums.second_moments[0], 1);
    // Numbers out of the range of floats are many, not none.
    EXPECT_GT(weigh_candidate({.own = 1, .others = 1}, {.own = 0, .others = 0}).by_density, 1e10f);
}

// Of thirteen blocks connections take nine tenths of the variance away in the first, and nothing in the others.
TEST(TechniqueChoice, ABlockHasWhatIsWorthItThere) {
    const std::vector<TechniqueCandidate> candidates{{0.5f, 0, false}, {0.5f, 1, false}};
    std::vector<JudgedBlock> judged{{10, 1}, {1, 2}};
    for (int wall = 0; wall < 12; ++wall) judged.insert(judged.end(), {{1, 1}, {1, 2}});
    const ChosenTechniques chosen = choose_techniques(candidates, judged);
    EXPECT_EQ(chosen.everywhere, 0u);  // 22 x 13 against 13 x 26
    std::vector<size_t> expected(13, 0);
    expected[0] = 1;
    EXPECT_EQ(chosen.of_blocks, expected);
    EXPECT_DOUBLE_EQ(chosen.gain, 22.0 * 13 / (13 * 14));
    // What is hardly better than what is best for the whole image is left.
    judged[0] = {2.5, 1};
    EXPECT_EQ(choose_techniques(candidates, judged).of_blocks, std::vector<size_t>(13, 0));
}

// Where the pilot saw no use for what the image has it stays: it may be rare.
TEST(TechniqueChoice, ABlockLacksNothingThatTheImageHas) {
    const std::vector<TechniqueCandidate> candidates{{0.5f, 0, false}, {0.5f, 0, true}};
    const std::vector<JudgedBlock> judged{{100, 1}, {1, 2}, {1, 1}, {1, 2}};
    const ChosenTechniques chosen = choose_techniques(candidates, judged);
    EXPECT_EQ(chosen.everywhere, 1u);
    EXPECT_EQ(chosen.of_blocks, (std::vector<size_t>{1, 1}));
}

// Against all choices there are that only add to an image's, of blocks and candidates drawn at random: never worse than
// one choice for the image, all blocks share their light paths, and few miss much of the least: blocks stay for 15 %.
TEST(TechniqueChoice, BlocksAreNearlyTheBestThereIs) {
    const std::vector<TechniqueCandidate> candidates{{0, 0, false},   {0.5f, 0, false}, {0.5f, 1, false},
                                                     {0.5f, 1, true}, {2, 0, false},    {2, 4, true}};
    const std::pair<size_t, size_t> groups[] = {{0, 1}, {1, 4}, {4, 6}};  // of one number of light paths, growing
    constexpr size_t kBlocks = 5;
    RandomStream random(7, RandomDomain::Test, 0, 0);
    size_t differ = 0, far = 0;
    for (int round = 0; round < 200; ++round) {
        std::vector<JudgedBlock> judged;
        for (size_t i = 0; i < kBlocks * candidates.size(); ++i)
            judged.push_back({std::exp(3.0 * double{random.next()}), std::exp(2.0 * double{random.next()})});
        const auto worth = [&](const std::vector<size_t>& of_blocks) {
            double variance = 0, cost = 0;
            for (size_t b = 0; b < kBlocks; ++b) {
                variance += judged[b * candidates.size() + of_blocks[b]].relative_variance;
                cost += judged[b * candidates.size() + of_blocks[b]].cost;
            }
            return variance * cost;
        };
        const auto alone = [&](size_t c) { return worth(std::vector<size_t>(kBlocks, c)); };
        double least = 1e30;
        for (const auto& [begin, end] : groups) {
            size_t first = begin;  // the best for the image; those behind it add to it
            for (size_t c = begin; c < end; ++c)
                if (alone(c) < alone(first)) first = c;
            std::vector<size_t> of_blocks(kBlocks, first);
            for (size_t b = 0; b < kBlocks;) {  // counts through all
                least = std::min(least, worth(of_blocks));
                for (b = 0; b < kBlocks && ++of_blocks[b] == end; ++b) of_blocks[b] = first;
            }
        }
        const ChosenTechniques chosen = choose_techniques(candidates, judged);
        const double everywhere = alone(chosen.everywhere), blocks = worth(chosen.of_blocks);
        EXPECT_LE(blocks, everywhere * (1 + 1e-12));
        EXPECT_NEAR(chosen.gain, everywhere / blocks, 1e-9 * chosen.gain);
        far += blocks > 1.1 * least;
        EXPECT_LE(blocks, 1.5 * least);
        for (const size_t c : chosen.of_blocks)
            EXPECT_EQ(candidates[c].light_paths, candidates[chosen.of_blocks[0]].light_paths);
        differ += std::ranges::any_of(chosen.of_blocks, [&](size_t c) { return c != chosen.of_blocks[0]; });
    }
    EXPECT_GT(differ, 50u);
    EXPECT_LT(far, 20u);
}

// Squares of very bright light leave the range of numbers: something is chosen nevertheless.
TEST(TechniqueChoice, EveryBlockHasTechniquesWhateverTheNumbers) {
    const std::vector<TechniqueCandidate> candidates{{0, 0, false}, {0.5f, 1, false}};
    for (const double strange : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
        const ChosenTechniques chosen = choose_techniques(candidates, std::vector<JudgedBlock>(6, {strange, 1}));
        ASSERT_EQ(chosen.of_blocks.size(), 3u);
        for (const size_t c : chosen.of_blocks) EXPECT_LT(c, 2u);
    }
}

TEST(TechniqueChoice, WhatIsGivenStays) {
    for (const TechniqueCandidate& candidate :
         technique_candidates({.light_paths = 0.3f, .most_light_paths = 2, .connections = 3, .merges = true})) {
        EXPECT_EQ(candidate.light_paths, 0.3f);
        EXPECT_EQ(candidate.connections, 3u);
    }
    const auto all = technique_candidates({.most_light_paths = 0.6f, .merges = true});
    EXPECT_EQ(all.size(), 1 + 3 * 5 * 2u);  // none; 1/4, 1/2 and the 0.6 that there is room for
    EXPECT_EQ(all.back().light_paths, 0.6f);
}

TEST(TechniqueChoice, WhatAloneMakesSomePathsIsInEveryCandidate) {
    for (const TechniqueCandidate& candidate : technique_candidates(
             {.most_light_paths = 2, .merges = true, .needs_light_paths = true, .needs_merges = true})) {
        EXPECT_GT(candidate.light_paths, 0);
        EXPECT_TRUE(candidate.merges);
    }
    for (const TechniqueCandidate& candidate :
         technique_candidates({.most_light_paths = 2, .needs_light_paths = true, .needs_connections = true}))
        EXPECT_GT(candidate.connections, 0u);
}

template <class M>
Stats begun(const char* name, Size2 size, uint64_t seed, int threads) {
    const Scene scene = make_builtin_scene(name);
    test::RenderSettingsOf<M> settings;
    settings.size = size, settings.seed = seed, settings.passes = 1;
    Stats stats;
    test::on_threads(threads, [&] {
        test::render(scene, settings, &stats);
        return 0;
    });
    return stats;
}

bool skips(const Stats& stats, std::string_view what) {
    return std::any_of(stats.skipped.begin(), stats.skipped.end(), [&](const Skipped& s) { return s.what == what; });
}

TEST(TechniqueChoice, ASimpleSceneDoesNotPay) {
    const Stats stats = begun<VertexConnectionAndMerging>("cornell-box", {96, 96}, 1, 2);
    EXPECT_TRUE(skips(stats, "light paths"));
    EXPECT_EQ(stats.counts.photons_emitted, 0u);
    // It is path tracing, to the bit.
    const Scene scene = make_builtin_scene("cornell-box");
    test::RenderSettings tracing{.size = {48, 48}, .passes = 2};
    test::RenderSettingsOf<VertexConnectionAndMerging> merging{.size = {48, 48}, .passes = 2};
    EXPECT_EQ(test::render(scene, merging).pixel_hash(), test::render(scene, tracing).pixel_hash());
}

TEST(TechniqueChoice, AHardSceneGetsLightPaths) {
    for (const char* name : {"cornell-box-glossy", "keyhole"}) {
        const Stats stats = begun<BidirectionalPathTracing>(name, {96, 96}, 1, 2);
        EXPECT_FALSE(skips(stats, "light paths")) << name;
        EXPECT_GT(stats.counts.photons_emitted, 0u) << name;
    }
}

TEST(TechniqueChoice, LightThatNothingElseBringsIsKept) {
    for (const char* name : {"small-vcm/sun", "small-vcm/point"}) {
        const Stats joined = begun<BidirectionalPathTracing>(name, {48, 48}, 1, 2),
                    merged = begun<VertexConnectionAndMerging>(name, {48, 48}, 1, 2);
        EXPECT_FALSE(skips(joined, "light paths") || skips(joined, "connections")) << name;
        EXPECT_FALSE(skips(merged, "light paths") || skips(merged, "merging")) << name;
    }
}

TEST(TechniqueChoice, FollowsFromTheSeedAlone) {
    for (const uint64_t seed : {1, 2}) {
        const Stats one = begun<VertexConnectionAndMerging>("cornell-box-glass", {64, 64}, seed, 1),
                    many = begun<VertexConnectionAndMerging>("cornell-box-glass", {64, 64}, seed, 8);
        EXPECT_EQ(one.counts.photons_emitted, many.counts.photons_emitted);
        EXPECT_EQ(one.counts.shadow_rays, many.counts.shadow_rays);
        EXPECT_EQ(skips(one, "merging"), skips(many, "merging"));
    }
}

}  // namespace
}  // namespace photond::technique_choice_test
