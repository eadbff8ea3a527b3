// The choice among texels by a pyramid of sums: the exact distribution, nothing that is worth nothing, well distributed
// choices; the curve the texels lie along; and whose they are. Chance of a false alarm of each chi-square check: 1e-6.

#include "renderer/many_lights/flux_map.h"

#include <gtest/gtest.h>

#include <limits>

#include "renderer/core/hilbert.h"
#include "renderer/core/rng.h"
#include "renderer/photons/texel_map.h"
#include "renderer/scene/builtin_families.h"
#include "renderer/scene/mesh_builder.h"
#include "tests/support/statistics.h"

namespace photond::flux_map_test {
namespace {

constexpr double kFalseAlarm = 1e-6;

/// Worth of very different sizes, every third texel without any.
FluxMap uneven_map(uint32_t levels) {
    FluxMap map(levels);
    RandomStream random(1, RandomDomain::Test, levels, 0);
    for (uint32_t i = 0; i < map.texels(); ++i)
        map.worth()[i] = i % 3 == 1 ? 0.0f : std::pow(random.next(), 4.0f) * (i % 64 < 16 ? 20.0f : 1.0f);
    map.sum();
    return map;
}

TEST(FluxMap, ChoosesByTheExactDistribution) {
    for (const uint32_t levels : {1u, 2u, 4u, 6u}) {
        const FluxMap map = uneven_map(levels);
        double total = 0;
        for (const float worth : map.worth()) total += double{worth};
        EXPECT_NEAR(double{map.total()}, total, 1e-6 * total);
        constexpr uint32_t kPoints = 400'000;
        std::vector<double> observed(map.texels()), expected(map.texels()), probability(map.texels());
        RandomStream random(2, RandomDomain::Test, levels, 0);
        for (uint32_t i = 0; i < kPoints; ++i) {
            const uint32_t x = random.next_bits();
            const Texel texel = map.choose({x, random.next_bits()});
            ++observed[texel.index];
            probability[texel.index] = double{texel.probability};
        }
        double sum = 0;
        for (uint32_t i = 0; i < map.texels(); ++i) {
            const double share = double{map.worth()[i]} / total;
            expected[i] = share * kPoints;
            if (observed[i] == 0) continue;
            EXPECT_NEAR(probability[i], share, 1e-5 * share + 1e-9);
            sum += probability[i];
        }
        EXPECT_GT(test::chi_square_probability(observed, expected), kFalseAlarm) << levels;
        if (levels < 4) {  // all were chosen
            EXPECT_NEAR(sum, 1, 1e-6);
        }
    }
}

// What is divided by is what points are divided by: counted over all of a grid of points a texel has its probability
// but for the grid's own steps, also where shares are tiny.
TEST(FluxMap, ProbabilitiesAreAreas) {
    FluxMap map(2);
    const float worth[16] = {1e-3f, 3, 0, 2, 5, 1e-6f, 1, 7, 0, 0, 0, 0, 2, 2, 1e-4f, 9};
    std::copy(std::begin(worth), std::end(worth), map.worth().begin());
    map.sum();
    constexpr uint32_t kSide = 2048;
    std::vector<double> area(16), probability(16);
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x) {
            const Texel texel = map.choose(uvec2(x, y) * (UINT32_MAX / kSide + 1) + (1u << 20));
            area[texel.index] += 1.0 / (double{kSide} * kSide);
            probability[texel.index] = double{texel.probability};
        }
    for (uint32_t i = 0; i < 16; ++i) EXPECT_NEAR(area[i], probability[i], worth[i] == 0 ? 0.0 : 4.0 / kSide) << i;
    // A worth far below the rounding of its neighbours' has a chance all the same.
    FluxMap tiny(1);
    tiny.worth()[0] = 1, tiny.worth()[2] = 1e-20f;
    tiny.sum();
    const Texel last = tiny.choose(uvec2(UINT32_MAX));
    EXPECT_EQ(last.index, 2u);
    EXPECT_GT(last.probability, 0);
}

TEST(FluxMap, WhatIsNoWorthIsNone) {
    constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
    FluxMap map(2);
    map.sum();
    EXPECT_EQ(map.total(), 0);
    for (const float none : {kNaN, kInfinity, -1.0f, 0.0f}) {
        map.worth()[3] = none;
        map.sum();
        EXPECT_EQ(map.total(), 0);
    }
    map.worth()[3] = kNaN;
    map.worth()[9] = 3e38f;  // sums of such would be infinite
    map.worth()[12] = 3e38f;
    map.sum();
    EXPECT_LT(map.total(), kInfinity);
    EXPECT_EQ(map.choose({1u << 31, 1u << 30}).probability, 0.5f);
    FluxMap one(0);
    one.worth()[0] = 2;
    one.sum();
    EXPECT_EQ(one.total(), 2);
    EXPECT_EQ(one.choose({7, 7}).probability, 1.0f);
    EXPECT_EQ(one.choose({7, 7}).index, 0u);
}

// Squares of deviations from the expected counts, of 16 x 16 blocks: independent points have their count's mean.
TEST(FluxMap, WellDistributedPointsMakeWellDistributedChoices) {
    const FluxMap map = uneven_map(6);
    constexpr uint32_t kPoints = 4096;
    double squares = 0, independent = 0;
    for (uint32_t pass = 0; pass < 16; ++pass) {
        RandomStream random(3, RandomDomain::Test, pass, 0);
        const uint32_t x = random.next_bits();
        const uvec2 rotation(x, random.next_bits());
        std::vector<double> observed(16), expected(16);
        for (uint32_t i = 0; i < kPoints; ++i) ++observed[map.choose(rotated_halton_point(i, rotation)).index / 256];
        for (uint32_t i = 0; i < map.texels(); ++i)
            expected[i / 256] += kPoints * double{map.worth()[i]} / double{map.total()};
        for (uint32_t b = 0; b < 16; ++b) {
            squares += (observed[b] - expected[b]) * (observed[b] - expected[b]);
            independent += expected[b] * (1 - expected[b] / kPoints);
        }
    }
    EXPECT_LT(squares, 0.05 * independent);
}

TEST(FluxMap, HaltonPointsAreTheSequences) {
    constexpr uint32_t kThird = 1'431'655'765, kNinth = 477'218'588;
    EXPECT_EQ(rotated_halton_point(0, {5, 6}), uvec2(5, 6));
    EXPECT_EQ(rotated_halton_point(1, {0, 0}), uvec2(1u << 31, kThird));
    EXPECT_EQ(rotated_halton_point(2, {0, 0}), uvec2(1u << 30, 2 * kThird));
    EXPECT_EQ(rotated_halton_point(3, {0, 0}), uvec2(3u << 30, kNinth));
    EXPECT_EQ(rotated_halton_point(1, {1u << 31, 0}), uvec2(0, kThird));
}

TEST(Hilbert, NeighboursOnTheCurveAreNeighboursInTheSquare) {
    constexpr uint64_t kStep = uint64_t{1} << (2 * kHilbertLevels - 12);  // 64 x 64 cells
    uvec2 before(0);
    for (uint64_t i = 0; i < 4096; ++i) {
        const uvec2 full = hilbert_cell(i * kStep), cell = full >> (kHilbertLevels - 6);
        EXPECT_EQ(hilbert_place(full), i * kStep);
        if (i > 0) {
            EXPECT_EQ(std::abs(int(cell.x) - int(before.x)) + std::abs(int(cell.y) - int(before.y)), 1) << i;
        }
        before = cell;
    }
    // The steps of the pyramid lead to the same cells.
    for (uint32_t i = 0; i < 64; ++i) {
        HilbertSquare square;
        uvec2 cell(0);
        for (int level = 2; level >= 0; --level) {
            const uint32_t child = i >> 2 * level & 3u;
            EXPECT_EQ(square.child(square.quadrant(child)), child);
            cell = 2u * cell + square.quadrant(child);
            square = square.below(child);
        }
        EXPECT_EQ(hilbert_cell(uint64_t{i} << (2 * kHilbertLevels - 6)) >> (kHilbertLevels - 3), cell);
    }
}

// Of any number of texels each has its share of the square, and is found again there.
TEST(TexelMap, PartsOfTheSquareAreEqual) {
    for (const uint32_t n : {1u, 3u, 16u, 100u, 777u}) {
        constexpr uint32_t kPoints = 200'000;
        RandomStream random(4, RandomDomain::Test, n, 0);
        std::vector<double> found(n), blocks(64);
        uint32_t elsewhere = 0;
        for (uint32_t i = 0; i < kPoints; ++i) {
            ++found[texel_at_place(random.next_2d(), n)];
            const uint32_t j = random.next_bits() % n;
            const vec2 place = place_in_square(j, n, random.next_2d());
            ASSERT_TRUE(place.x > 0 && place.x < 1 && place.y > 0 && place.y < 1);
            elsewhere += texel_at_place(place, n) != j;
            ++blocks[static_cast<uint32_t>(place.x * 8) + 8 * static_cast<uint32_t>(place.y * 8)];
        }
        EXPECT_LT(elsewhere, 3u);  // on the border, to within 2^-44
        if (n > 1) {
            EXPECT_GT(test::chi_square_probability(found, std::vector<double>(n, kPoints / double(n))), kFalseAlarm);
        }
        EXPECT_GT(test::chi_square_probability(blocks, std::vector<double>(64, kPoints / 64.0)), kFalseAlarm);
    }
}

/// Spot lights of those intensities, all of one cone.
Scene spots(std::span<const float> intensities) {
    Scene scene;
    add_mesh(scene, MeshBuilder()
                        .quad({-9, 0, 9}, {9, 0, 9}, {9, 0, -9}, {-9, 0, -9})
                        .build(add_material(scene, lambert("floor", Rgb(0.5f)))));
    PunctualLight spot;
    spot.kind = PunctualLight::Kind::Spot;
    spot.position = {0, 2, 0};
    spot.direction = {0, -1, 0};
    spot.cos_inner = 0.95f;
    spot.cos_outer = 0.9f;
    for (const float intensity : intensities) {
        spot.intensity = Rgb(intensity);
        scene.punctual_lights.push_back(spot);
    }
    finish_scene(scene);
    return scene;
}

// Texels in proportion to what chooses the lights, all of them used but what weak lights leave; a light that has the
// whole map has it as it is.
TEST(TexelMap, SharesTheMapOutAsLightsAreChosen) {
    const float intensities[] = {5, 1, 0.001f, 2, 0.0005f, 0, 0.01f};
    const Scene scene = spots(intensities);
    const EmissionSampler emission(scene);
    const TexelMap map(emission, 8);
    ASSERT_EQ(map.runs().size(), 3u);
    ASSERT_EQ(map.weak().size(), 3u);
    uint32_t next = 0;
    for (const gpu::TexelRun& run : map.runs()) {
        EXPECT_EQ(run.first_texel, next);
        EXPECT_EQ(run.expected, static_cast<float>(run.texels));
        // Of 64 texels weak lights expect 2.1, for which 3 are kept free: the strong ones have 61 instead of 61.9.
        EXPECT_NEAR(double(run.texels), 61 / 61.9 * 64 * double{emission.probability(run.light)}, 1);
        next += run.texels;
    }
    // Each of six lights has at least a sixth of the sixteenth that all share, 0.67 texels.
    EXPECT_EQ(next, 61u);

    const float alone[] = {3};
    const Scene one = spots(alone);
    const EmissionSampler one_emission(one);
    const TexelMap whole(one_emission, 32);
    ASSERT_EQ(whole.runs().size(), 1u);
    EXPECT_EQ(whole.runs()[0].texels, 1024u);
    const uvec2 cell = hilbert_cell(uint64_t{77} << (2 * kHilbertLevels - 10)) >> (kHilbertLevels - 5);
    EXPECT_EQ(uvec2(place_in_square(77, 1024, {0.3f, 0.9f}) * 32.0f), cell);
}

TEST(TexelMap, WeakLightsTakeTurns) {
    std::vector<float> intensities = {1};
    for (uint32_t i = 0; i < 40; ++i) intensities.push_back(1e-3f * static_cast<float>(i + 1));
    const Scene scene = spots(intensities);
    const EmissionSampler emission(scene);
    constexpr uint32_t kPasses = 4'000;
    const TexelMap map(emission, 8);
    std::vector<double> seen(emission.lights()), power(emission.lights());
    for (uint32_t p = 0; p < kPasses; ++p) {
        const TexelMapPass pass(map, 1, p);
        EXPECT_LE(pass.texels(), map.texels());
        EXPECT_GE(pass.texels(), map.texels() - 1);
        for (uint32_t texel = 0; texel < pass.texels(); ++texel) {
            EmissionSample sample;
            ASSERT_TRUE(pass.sample(texel, vec2(0.5f), vec2(0.5f), vec2(0.5f), sample));
            seen[sample.light] += 1.0 / kPasses;
            power[sample.light] += double{sample.power_w.x} / kPasses;
        }
    }
    const double flux = power[0];
    for (uint32_t light = 1; light < intensities.size(); ++light) {
        const double expected = double{emission.probability(light)} * map.texels();
        const double of_it = flux * double{intensities[light]};
        if (expected >= 1) {
            EXPECT_NEAR(power[light], of_it, 1e-5 * flux);
            continue;
        }
        // Six standard deviations of a light's turns, which come independently in each pass.
        EXPECT_NEAR(seen[light], expected, 6 * std::sqrt(expected * (1 - expected) / kPasses)) << light;
        EXPECT_NEAR(power[light] / seen[light] * expected, of_it, 1e-5 * flux);
    }
}

TEST(TexelMap, HasRoomForAnyNumberOfLights) {
    for (const uint32_t lights : {0u, 1u, 3u, 1023u, 1024u, 1025u, 10'000u})
        for (const uint32_t side : {1u, 4u, 32u}) {
            const Scene scene = spots(std::vector<float>(lights, 2.0f));
            const EmissionSampler emission(scene);
            const TexelMap map(emission, side);
            for (uint32_t p = 0; p < 5; ++p) {
                const TexelMapPass pass(map, 1, p);
                EXPECT_NEAR(double(pass.texels()), lights == 0 ? 0.0 : double(map.texels()), lights == 0 ? 0 : 1);
                EXPECT_LE(pass.texels(), map.texels());
                double power = 0;
                for (uint32_t texel = 0; texel < pass.texels(); ++texel) {
                    EmissionSample sample;
                    ASSERT_TRUE(pass.sample(texel, vec2(0.5f), vec2(0.5f), vec2(0.5f), sample));
                    power += double{sample.power_w.x};
                }
                EXPECT_NEAR(power, emission.total_power_w(), 1.1 * emission.total_power_w() / map.texels());
            }
        }
}

}  // namespace
}  // namespace photond::flux_map_test
