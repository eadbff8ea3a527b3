// Cells of the frame before in the radiance cache: how they age, the same bits whoever renders a frame, less noise in a
// still scene, and light that is forgotten.

#include "renderer/methods/radiance_cache/aged_cells.h"

#include <gtest/gtest.h>

#include "protocol/error.h"
#include "renderer/gbuffer/temporal_reprojection.h"
#include "renderer/methods/radiance_cache/radiance_cache.h"
#include "renderer/methods/radiance_cache/radiance_cells.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/aged_frames.h"
#include "tests/support/statistics.h"
#include "tests/support/threads.h"

namespace photond::aged_cells_test {
namespace {

using test::FrameOf;
using Settings = test::RenderSettingsOf<RadianceCache>;

/// A scene as the tests of a frame hold it.
struct Still {
    explicit Still(Scene of) : scene(std::move(of)), intersector(make_embree_intersector(scene, budget, stats)) {}

    MemoryBudget budget;
    Stats stats;
    const Scene scene;
    const std::unique_ptr<Intersector> intersector;

    RenderContext context(const Settings& settings) {
        return {scene, intersector.get(), test::view_of(scene, settings), settings.seed, budget};
    }
    FrameOf frame(const Settings& settings, const std::string& before = {}) {
        RadianceCache method(settings.params);
        return test::frame_after(method, context(settings), settings, before);
    }
};

TEST(AgedCells, CountForLessAndAreDroppedUnseen) {
    constexpr uint32_t kAge = 4, kCells = 4096;
    RadianceCacheParams params;
    params.aged = true, params.cache_age = kAge, params.cells = kCells;
    LeftCells left{.buckets = RadianceCells::buckets_for(kCells), .origin = {1, 2, 3}, .coarsest_m = 7, .cells = {}};
    for (uint32_t bucket = 0; bucket < left.buckets; ++bucket)
        left.cells.push_back({bucket, bucket + 1, {3, 0, 1}, 1, 0});
    left.cells[5].samples = 1000, left.cells[6].samples = 1000;
    left.cells[6].frames_unseen = kAge;
    const LeftCells back = LeftCells::decode(left.encode(), left.buckets);
    EXPECT_EQ(back.origin, left.origin);
    const AgedCells aged(back, kAge, 1);
    // Of single samples three in four are left.
    const double n = static_cast<double>(left.buckets);
    const double z = test::two_sided_z(1e-6);
    EXPECT_NEAR(static_cast<double>(aged.cells.size()), 0.75 * n, z * std::sqrt(0.75 * 0.25 * n));
    RadianceCells cells(kCells);
    cells.begin_with(aged);
    const RadianceCells::Mean mean = cells.find({5, 6});
    EXPECT_EQ(mean.samples, 750u);
    EXPECT_NEAR(mean.radiance.x, 3, 1e-5);
    EXPECT_EQ(mean.radiance.y, 0);
    EXPECT_EQ(cells.find({6, 7}).samples, 0u) << "unseen for too long";
    // Frame by frame, in which nothing sees it.
    const CellsBetweenFrames frames(params);
    for (uint32_t frame = 1; frame <= kAge; ++frame) {
        LeftCells next{.buckets = left.buckets, .origin = {}, .coarsest_m = 1, .cells = {}};
        cells.for_each([&](uint32_t slot, uint32_t fingerprint, const RadianceCells::Mean& known, uint32_t last_round) {
            frames.append(next, slot, fingerprint, known.radiance, known.samples, last_round);
        });
        cells.clear();
        cells.begin_with(AgedCells(next, kAge, frame));
        EXPECT_EQ(cells.find({5, 6}).samples > 0, frame < kAge) << frame;
    }
    for (const std::string& wrong : {std::string("no cells"), left.encode() + "x"})
        EXPECT_THROW(LeftCells::decode(wrong, left.buckets), Error);
    EXPECT_THROW(LeftCells::decode(left.encode(), 2 * left.buckets), Error);
}

TEST(AgedCells, FramesAreTheSameWhoeverRendersThem) {
    Still still(make_builtin_scene("cornell-box-glossy"));
    Settings settings = test::aged_settings<RadianceCache>(5);
    settings.params.cells = 512;  // not enough
    const FrameOf first = still.frame(settings);
    settings.seed = 2;
    const FrameOf second = still.frame(settings, first.left);
    EXPECT_NE(second.film.pixel_hash(), still.frame(settings).film.pixel_hash()) << "it follows";
    for (const int threads : {1, 8}) {
        const FrameOf again = test::on_threads(threads, [&] { return still.frame(settings, first.left); });
        EXPECT_EQ(again.film.pixel_hash(), second.film.pixel_hash()) << threads;
        EXPECT_EQ(again.left, second.left) << threads;
    }
    // Another worker goes on with the last two passes.
    Settings part = settings;
    part.passes = 3;
    FrameOf begun = still.frame(part, first.left);
    part.first_pass = 3, part.passes = 2;
    const FrameOf ended = still.frame(part, first.left);
    begun.film.merge(ended.film);
    EXPECT_EQ(begun.film.pixel_hash(), second.film.pixel_hash());
    EXPECT_EQ(ended.left, second.left);
    RadianceCache method(settings.params);
    method.follow({first.left, nullptr});
    EXPECT_NO_THROW(method.go_on_from(begun.state));
    RadianceCache other(settings.params);
    other.follow({second.left, nullptr});
    EXPECT_THROW(other.go_on_from(begun.state), Error);
}

/// Half the mean squared difference of two images by seeds of their own, over blocks of pixels, for the pixels' own
/// rays are noisier than what ageing smooths.
double variance_of_blocks(const Film& a, const Film& b) {
    constexpr uint32_t kSide = 8;
    const std::vector<float> of_a = a.resolve(Layer::Indirect), of_b = b.resolve(Layer::Indirect);
    const Size2 size = a.size();
    double sum = 0;
    uint32_t blocks = 0;
    for (uint32_t y = 0; y < size.height; y += kSide)
        for (uint32_t x = 0; x < size.width; x += kSide, ++blocks) {
            double difference = 0;
            for (uint32_t j = 0; j < kSide; ++j)
                for (uint32_t i = 0; i < 3 * kSide; ++i) {
                    const size_t at = 3 * (size_t{y + j} * size.width + x) + i;
                    difference += double{of_a[at]} - double{of_b[at]};
                }
            sum += difference * difference / 2;
        }
    return sum / blocks;
}

TEST(AgedCells, LessNoiseInAStillScene) {
    Still still(make_builtin_scene("cornell-box"));
    constexpr uint32_t kFrames = 8, kPairs = 96;
    const auto last_frame = [&](uint64_t seed, uint32_t frames) {
        Settings settings = test::aged_settings<RadianceCache>(1);
        settings.params.cell_size = 0.3f;  // so that cells of one frame know enough to be asked
        settings.params.training = 1;
        std::string left;
        for (uint32_t frame = 1; frame < frames; ++frame) {
            settings.seed = 1000 * seed + frame;
            settings.params.gather_rays = 1;  // nobody looks at them
            left = still.frame(settings, left).left;
        }
        settings.seed = 1000 * seed;
        settings.params.gather_rays = 16;
        return still.frame(settings, left).film;
    };
    test::RunningMean fresh, aged;
    for (uint64_t pair = 0; pair < kPairs; ++pair) {
        // Logarithms, for a bright dot in one pair would hide what the others tell.
        fresh.add(std::log(variance_of_blocks(last_frame(2 * pair + 1, 1), last_frame(2 * pair + 2, 1))));
        aged.add(std::log(variance_of_blocks(last_frame(2 * pair + 1, kFrames), last_frame(2 * pair + 2, kFrames))));
    }
    std::printf("variance of an aged frame over that of a fresh one: %.3f\n", std::exp(aged.mean() - fresh.mean()));
    const double doubt = test::two_sided_z(1e-6) * std::hypot(aged.standard_error(), fresh.standard_error());
    EXPECT_LT(aged.mean() + doubt, fresh.mean());
}

TEST(AgedCells, ForgetALampThatIsDimmed) {
    constexpr float kDimmed = 0.05f;
    Scene dim = make_builtin_scene("cornell-box");
    for (Material& material : dim.materials) material.emission *= kDimmed;
    finish_scene(dim);
    Still bright(make_builtin_scene("cornell-box")), dimmed(std::move(dim));
    constexpr uint32_t kBright = 4, kForgotten = 28, kChains = 8;
    test::RunningMean next, last, fresh;
    for (uint64_t chain = 0; chain < kChains; ++chain) {
        Settings settings = test::aged_settings<RadianceCache>(1);
        settings.params.cache_age = 4;
        settings.params.training = 2;
        std::string left;
        for (uint32_t frame = 0; frame < kBright + kForgotten; ++frame) {
            settings.seed = 1 + 1000 * chain + frame;
            const FrameOf now = (frame < kBright ? bright : dimmed).frame(settings, left);
            left = now.left;
            const double light = test::mean_of(now.film.resolve(Layer::Indirect));
            if (frame == kBright) next.add(light);
            if (frame + 1 == kBright + kForgotten) last.add(light);
        }
        for (uint64_t seed = 0; seed < 4; ++seed) {
            settings.seed = 1'000'000 + 4 * chain + seed;
            fresh.add(test::mean_of(dimmed.frame(settings).film.resolve(Layer::Indirect)));
        }
    }
    std::printf("light of the first frame after over the truth: %.2f; of the last: %.4f\n", next.mean() / fresh.mean(),
                last.mean() / fresh.mean());
    EXPECT_GT(next.mean(), 2 * fresh.mean()) << "it lags";
    // What is left of the light before: three quarters a frame of the samples are old ones.
    const double old = std::pow(0.75, kForgotten) / double{kDimmed};
    const double doubt =
        test::two_sided_t(1e-6, kChains - 1) * std::hypot(last.standard_error(), fresh.standard_error());
    EXPECT_NEAR(last.mean() / fresh.mean(), 1, old + doubt / fresh.mean());
    EXPECT_LT(doubt, fresh.mean()) << "too noisy to notice a defect";
}

TEST(AgedCells, GoWithTemporalReprojection) {
    Still still(make_builtin_scene("cornell-box"));
    Settings settings = test::aged_settings<RadianceCache>(3);
    TemporalParams temporal;
    temporal.reuse = TemporalReuse::Reproject;
    const auto make = [&] { return TemporalReprojection(std::make_unique<RadianceCache>(settings.params), temporal); };
    const auto frame = [&](const std::string& before) {
        TemporalReprojection method = make();
        return test::frame_after(method, still.context(settings), settings, before);
    };
    const FrameOf first = frame({});
    settings.seed = 2;
    const FrameOf second = frame(first.left), again = frame(first.left);
    EXPECT_EQ(second.film.pixel_hash(), again.film.pixel_hash());
    EXPECT_EQ(second.left, again.left);
    EXPECT_NE(second.left, first.left);
    Settings plain = settings;
    plain.params.aged = false;
    TemporalReprojection not_aged(std::make_unique<RadianceCache>(plain.params), temporal);
    EXPECT_THROW(not_aged.follow({first.left, nullptr}), Error) << "cells that nobody takes over";
    // A worker dies after the first pass; another goes on from its film.
    const uint32_t passes = std::exchange(settings.passes, 1);
    FrameOf begun = frame(first.left);
    settings.first_pass = 1, settings.passes = passes - 1;
    TemporalReprojection method = make();
    const FrameOf ended = test::frame_after(method, still.context(settings), settings, first.left, begun.state);
    begun.film.merge(ended.film);
    EXPECT_EQ(begun.film.pixel_hash(), second.film.pixel_hash());
    EXPECT_EQ(ended.left, second.left);
    EXPECT_THROW(make().go_on_from("x"), Error);
}

}  // namespace
}  // namespace photond::aged_cells_test
