// Stratified photons: which cells there are, which photons stand for them, with what power; memory; threads.

#include "renderer/methods/photon_splatting/stratification.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <set>

#include "renderer/scene/builtin_scenes.h"
#include "tests/support/photons.h"
#include "tests/support/threads.h"

namespace photond::stratification_test {
namespace {

ReflectedPhoton photon_at(const vec3& position, const Rgb& power_w = Rgb(1), const vec3& direction = {0, 0, 1}) {
    ReflectedPhoton photon;
    photon.position = position;
    photon.power_w = power_w;
    photon.direction = direction;
    return photon;
}

/// Of 8 cells along each side of 8 m: cells are a metre wide.
StratificationSettings eight_cells(Representative representative = Representative::ByPower, uint32_t splats = 1) {
    StratificationSettings settings;
    settings.bounds = {vec3(0), vec3(8)};
    settings.cells = 8;
    settings.minimum_photons = 1;
    settings.splats_per_cell = splats;
    settings.representative = representative;
    return settings;
}

std::vector<SplatSource> run(std::span<const ReflectedPhoton> photons, const StratificationSettings& settings,
                             uint64_t seed = 1, uint32_t pass = 0) {
    uint64_t peak_bytes = 0;
    const std::vector<SplatSource> splats = stratify(photons, settings, seed, pass, peak_bytes);
    EXPECT_LE(peak_bytes + splats.capacity() * sizeof(SplatSource), stratification_bytes(photons.size()));
    return splats;
}

double photons_of(const std::vector<SplatSource>& splats) {
    double sum = 0;
    for (const SplatSource& splat : splats) sum += double{splat.photons};
    return sum;
}
dvec3 power_of(const std::vector<SplatSource>& splats) {
    dvec3 sum(0);
    for (const SplatSource& splat : splats) sum += dvec3(splat.power_w);
    return sum;
}

void expect_near(const dvec3& a, const dvec3& b, double relative) {
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(a[k], b[k], relative * std::abs(b[k]));
}

/// Random photons in a box, of powers over three orders of magnitude.
std::vector<ReflectedPhoton> random_photons(size_t count, uint64_t seed, const Bounds3& box = {vec3(0), vec3(8)}) {
    RandomStream random(seed, RandomDomain::Test, 0, 0);
    const auto number = [&] { return random.next(); };
    std::vector<ReflectedPhoton> photons;
    for (size_t i = 0; i < count; ++i) {
        const vec3 p = box.min + box.diagonal() * vec3(number(), number(), number());
        const Rgb power = std::exp(7 * number()) * Rgb(number(), number(), number());
        photons.push_back(photon_at(p, power, glm::normalize(vec3(number(), number(), number()) + 0.01f)));
    }
    return photons;
}

constexpr Representative kAll[] = {Representative::Random, Representative::ByPower, Representative::ClosestToMean,
                                   Representative::DominantDirection};

TEST(Stratification, NoPhotonsOnePhotonAndPhotonsWithoutPower) {
    for (const Representative representative : kAll) {
        EXPECT_TRUE(run({}, eight_cells(representative)).empty());
        std::vector<ReflectedPhoton> photons = {photon_at({1, 2, 3}, {1, 2, 3})};
        std::vector<SplatSource> splats = run(photons, eight_cells(representative, 3));
        ASSERT_EQ(splats.size(), 1u);
        EXPECT_EQ(splats[0].photon, 0u);
        EXPECT_EQ(splats[0].power_w, Rgb(1, 2, 3));
        EXPECT_EQ(splats[0].photons, 1);
        // Black photons about it change nothing, and alone make nothing.
        photons.insert(photons.begin(), 5, photon_at({1, 2, 3}, Rgb(0)));
        splats = run(photons, eight_cells(representative));
        ASSERT_EQ(splats.size(), 1u);
        EXPECT_EQ(splats[0].photon, 5u);
        EXPECT_EQ(splats[0].power_w, Rgb(1, 2, 3));
        EXPECT_EQ(splats[0].photons, 1);
        photons.pop_back();
        EXPECT_TRUE(run(photons, eight_cells(representative)).empty());
    }
}

TEST(Stratification, PhotonsOutsideSplatAloneAndLast) {
    std::vector<ReflectedPhoton> photons;
    for (int i = 0; i < 3; ++i) photons.push_back(photon_at({20, 0, 0}, Rgb(float(i + 1))));
    photons.push_back(photon_at({4, 4, std::numeric_limits<float>::quiet_NaN()}, Rgb(4)));
    for (int i = 0; i < 2; ++i) photons.push_back(photon_at({4, 4, 4}, Rgb(5)));
    StratificationSettings settings = eight_cells();
    settings.minimum_photons = 100;  // which joins none of those outside
    std::vector<SplatSource> splats = run(photons, settings);
    ASSERT_EQ(splats.size(), 5u);
    EXPECT_EQ(splats[0].photons, 2);
    for (uint32_t i = 0; i < 4; ++i) {
        EXPECT_EQ(splats[i + 1].photon, i);
        EXPECT_EQ(splats[i + 1].power_w, photons[i].power_w);
        EXPECT_EQ(splats[i + 1].photons, 1);
    }
    // Without bounds all are outside; about a single point there is one cell.
    settings.bounds = {};
    EXPECT_EQ(run(photons, settings).size(), photons.size());
    settings.bounds = {vec3(4), vec3(4)};
    settings.minimum_photons = 1;
    EXPECT_EQ(run(photons, settings).size(), 5u);
}

TEST(Stratification, PhotonsOnTheBoundsAreInsideForEveryShiftAndGrid) {
    // On each corner of the bounds two photons, by a rounding inside and outside: no splat is of one photon.
    for (const uint32_t cells : {1u, 2u, 5u, 64u, 256u, 1024u}) {
        for (uint32_t pass = 0; pass < 50; ++pass) {
            StratificationSettings settings = eight_cells();
            settings.cells = cells;
            settings.minimum_photons = 2;
            std::vector<ReflectedPhoton> photons;
            for (int corner = 0; corner < 8; ++corner) {
                const vec3 p(corner & 1 ? 8 : 0, corner & 2 ? 8 : 0, corner & 4 ? 8 : 0);
                photons.push_back(photon_at(p + 1e-5f));
                photons.push_back(photon_at(p - 1e-5f));
            }
            const std::vector<SplatSource> splats = run(photons, settings, 1, pass);
            EXPECT_EQ(photons_of(splats), 16);
            for (const SplatSource& splat : splats) EXPECT_GE(splat.photons, 2);
        }
    }
}

TEST(Stratification, TheGridIsShiftedByLessThanACellAlongEachAxis) {
    // Photons 0.05 cells apart along a line: where they part moves from pass to pass, over the whole cell.
    for (int axis = 0; axis < 3; ++axis) {
        std::set<uint32_t> parts;
        for (uint32_t pass = 0; pass < 200; ++pass) {
            std::vector<ReflectedPhoton> photons;
            for (int i = 0; i < 20; ++i) {
                vec3 p(4.0f);
                p[axis] += 0.05f * static_cast<float>(i);
                photons.push_back(photon_at(p));
            }
            const std::vector<SplatSource> splats = run(photons, eight_cells(), 1, pass);
            ASSERT_LE(splats.size(), 2u) << "cells are a metre wide";
            parts.insert(static_cast<uint32_t>(splats[0].photons));
        }
        // 20 places, each left out with probability 0.95^200 < 4e-5.
        EXPECT_EQ(parts.size(), 20u);
    }
}

/// The splats' photons as the brute-force rule has them: cells by their coordinates, joined level by level from below.
std::multiset<size_t> joined_by_hand(const std::vector<glm::ivec3>& cells, size_t minimum_photons, uint32_t levels) {
    struct Block {
        std::vector<size_t> cells;  // counts of photons; one once joined
        size_t photons() const { return std::accumulate(cells.begin(), cells.end(), size_t{0}); }
    };
    const auto less = [](const glm::ivec3& a, const glm::ivec3& b) {
        return std::array{a.x, a.y, a.z} < std::array{b.x, b.y, b.z};
    };
    std::map<glm::ivec3, Block, decltype(less)> blocks(less);
    for (const glm::ivec3& cell : cells) {
        Block& block = blocks[cell];
        if (block.cells.empty()) block.cells.push_back(0);
        ++block.cells[0];
    }
    for (uint32_t level = 0; level < levels; ++level) {
        std::map<glm::ivec3, std::vector<Block>, decltype(less)> parents(less);
        for (const auto& [cell, block] : blocks) parents[cell / 2].push_back(block);
        blocks.clear();
        for (const auto& [cell, children] : parents) {
            Block joined;
            bool too_few = false;
            for (const Block& child : children) {
                too_few |= child.photons() < minimum_photons;
                joined.cells.insert(joined.cells.end(), child.cells.begin(), child.cells.end());
            }
            if (too_few) joined.cells = {joined.photons()};
            blocks[cell] = joined;
        }
    }
    std::multiset<size_t> counts;
    for (const auto& [cell, block] : blocks) counts.insert(block.cells.begin(), block.cells.end());
    return counts;
}

TEST(Stratification, CellsOfTooFewPhotonsAreJoinedWithTheirBlockLevelByLevel) {
    // The shift is known: the first three numbers of the pass's stream (stratification.cpp).
    RandomStream random(3, RandomDomain::Test, 0, 0);
    for (uint32_t pass = 0; pass < 30; ++pass) {
        RandomStream shift(1, RandomDomain::Stratification, pass, ~uint64_t{0});
        vec3 first;
        for (int axis = 0; axis < 3; ++axis) first[axis] = 0.5f + shift.next();
        std::vector<ReflectedPhoton> photons;
        std::vector<glm::ivec3> cells;
        for (int i = 0; i < 60 * int(pass); ++i) {  // crowded towards a corner
            const vec3 p = 8.0f * vec3(sqr(random.next()), sqr(random.next()), sqr(random.next()));
            photons.push_back(photon_at(p));
            cells.push_back(glm::ivec3(p + first));
        }
        for (const uint32_t minimum : {0u, 1u, 2u, 3u, 8u, 100u, 100'000u}) {
            StratificationSettings settings = eight_cells();
            settings.minimum_photons = minimum;
            std::multiset<size_t> counts;
            for (const SplatSource& splat : run(photons, settings, 1, pass))
                counts.insert(static_cast<size_t>(splat.photons));
            EXPECT_EQ(counts, joined_by_hand(cells, minimum, 4)) << "pass " << pass << ", minimum " << minimum;
            EXPECT_LE(counts.size(), minimum > photons.size() ? 1u : photons.size());
        }
    }
}

/// Photons of one cell that no shift parts: all within one point.
std::vector<ReflectedPhoton> two_colours() {
    std::vector<ReflectedPhoton> photons;
    for (int i = 0; i < 10; ++i) photons.push_back(photon_at(vec3(4), i < 7 ? Rgb(2, 0.5f, 0) : Rgb(0, 0.1f, 4)));
    return photons;
}

TEST(Stratification, ByPowerHasTheCellsMeanOfRgbEachTimeAndTheColourOfThePhotonChosen) {
    const std::vector<ReflectedPhoton> photons = two_colours();
    for (uint32_t pass = 0; pass < 100; ++pass) {
        const std::vector<SplatSource> splats = run(photons, eight_cells(), 1, pass);
        ASSERT_EQ(splats.size(), 1u);
        const Rgb own = photons[splats[0].photon].power_w, splat = splats[0].power_w;
        EXPECT_NEAR(mean(splat), (7 * 2.5f + 3 * 4.1f) / 3, 1e-5);
        expect_near(dvec3(splat), dvec3(own) * double{mean(splat) / mean(own)}, 1e-6);
        EXPECT_EQ(splats[0].photons, 10);
    }
}

TEST(Stratification, TheTwoOfTheThesisChooseWhatTheySayWithTheSummedPower) {
    std::vector<ReflectedPhoton> photons;
    // Positions' mean is (4.04, 4, 4); directions weigh with their power.
    photons.push_back(photon_at({4.00f, 4, 4}, Rgb(1, 0, 0), {1, 0, 0}));
    photons.push_back(photon_at({4.03f, 4, 4}, Rgb(0, 1, 0), {0, 1, 0}));
    photons.push_back(photon_at({4.09f, 4, 4}, Rgb(0, 0, 9), glm::normalize(vec3(0, 0.2f, 1))));
    for (const bool mean_power : {false, true}) {
        for (uint32_t splats_per_cell : {1u, 2u, 5u}) {
            for (const auto& [representative, expected] :
                 {std::pair{Representative::ClosestToMean, 1u}, std::pair{Representative::DominantDirection, 2u}}) {
                StratificationSettings settings = eight_cells(representative, splats_per_cell);
                settings.minimum_photons = 3;  // so that no shift parts them
                settings.mean_power = mean_power;
                const std::vector<SplatSource> splats = run(photons, settings);
                ASSERT_EQ(splats.size(), 1u);
                EXPECT_EQ(splats[0].photon, expected);
                EXPECT_EQ(splats[0].photons, 3);
                expect_near(dvec3(splats[0].power_w), dvec3(1, 1, 9) / (mean_power ? 3.0 : 1.0), 1e-6);
            }
        }
    }
    // Directions that cancel, and all photons in one point: any will do, the first does.
    for (ReflectedPhoton& p : photons) p.position = vec3(4), p.power_w = Rgb(1);
    photons.pop_back();
    photons[1].direction = {-1, 0, 0};
    EXPECT_EQ(run(photons, eight_cells(Representative::ClosestToMean)).at(0).photon, 0u);
    EXPECT_EQ(run(photons, eight_cells(Representative::DominantDirection)).at(0).photon, 0u);
}

TEST(Stratification, SeveralSplatsShareTheCellsPhotonsAndPower) {
    const std::vector<ReflectedPhoton> photons = random_photons(1000, 5, {vec3(4), vec3(4)});
    dvec3 sum(0);
    for (const ReflectedPhoton& p : photons) sum += dvec3(p.power_w);
    for (const uint32_t m : {2u, 7u, 999u}) {
        const std::vector<SplatSource> by_power = run(photons, eight_cells(Representative::ByPower, m));
        ASSERT_EQ(by_power.size(), m);
        for (const SplatSource& splat : by_power) {
            const dvec3 w(splat.power_w);
            EXPECT_NEAR((w.x + w.y + w.z) * m, sum.x + sum.y + sum.z, 1e-5 * (sum.x + sum.y + sum.z));
            EXPECT_NEAR(splat.photons * float(m), 1000, 1e-3);
        }
        const std::vector<SplatSource> random = run(photons, eight_cells(Representative::Random, m));
        ASSERT_EQ(random.size(), m);
        std::set<uint32_t> chosen;
        for (const SplatSource& splat : random) {
            chosen.insert(splat.photon);
            expect_near(dvec3(splat.power_w), dvec3(photons[splat.photon].power_w) * (1000.0 / m), 1e-6);
        }
        EXPECT_EQ(chosen.size(), m) << "none twice";
    }
    for (const Representative representative : {Representative::Random, Representative::ByPower}) {
        std::vector<SplatSource> all = run(photons, eight_cells(representative, 1000));
        ASSERT_EQ(all.size(), 1000u);
        for (uint32_t i = 0; i < 1000; ++i) {
            EXPECT_EQ(all[i].photon, i);
            EXPECT_EQ(all[i].power_w, photons[i].power_w);
            EXPECT_EQ(all[i].photons, 1);
        }
        StratificationSettings mean = eight_cells(representative, 4);
        mean.mean_power = true;
        for (const SplatSource& splat : run(photons, mean)) {
            expect_near(dvec3(splat.power_w), sum / 1000.0, 1e-6);
            EXPECT_EQ(splat.photons, 250);
        }
    }
}

TEST(Stratification, AMillionPhotonsInOneCell) {
    std::vector<ReflectedPhoton> photons(1'000'000, photon_at(vec3(4), Rgb(1, 2, 3)));
    photons[777'777].power_w = Rgb(3e12f);  // nearly all power is in one
    for (const Representative representative : kAll) {
        const std::vector<SplatSource> splats = run(photons, eight_cells(representative));
        ASSERT_EQ(splats.size(), 1u);
        EXPECT_EQ(splats[0].photons, 1e6f);
        EXPECT_TRUE(is_finite(splats[0].power_w) && !is_black(splats[0].power_w));
        EXPECT_TRUE(representative != Representative::ByPower || splats[0].photon == 777'777u);
    }
    const std::vector<SplatSource> four = run(photons, eight_cells(Representative::ByPower, 4));
    for (const SplatSource& splat : four) EXPECT_EQ(splat.photon, 777'777u) << "chosen more than once";
    expect_near(power_of(four), dvec3(3e12), 1e-5);
}

TEST(Stratification, PowersOfAllMagnitudesStayFinite) {
    std::vector<ReflectedPhoton> photons;
    for (const float w : {1e-45f, 1e-38f, 1e-20f, 1.0f, 1e20f, 3e37f})
        for (const Rgb& c : {Rgb(1, 0, 0), Rgb(1, 1, 1)}) photons.push_back(photon_at(vec3(4), w * c));
    for (const Representative representative : kAll) {
        for (size_t first = 0; first < photons.size(); ++first) {
            for (const SplatSource& splat : run(std::span(photons).subspan(first), eight_cells(representative, 3)))
                EXPECT_TRUE(is_finite(splat.power_w));
        }
    }
}

TEST(Stratification, IsTheSameForAnyNumberOfThreads) {
    const std::vector<ReflectedPhoton> photons = random_photons(200'000, 8);
    StratificationSettings settings = eight_cells(Representative::ByPower, 2);
    settings.cells = 40;
    settings.minimum_photons = 3;
    const auto on = [&](int threads) {
        return test::on_threads(threads, [&] { return run(photons, settings, 4, 2); });
    };
    const std::vector<SplatSource> one = on(1), four = on(4);
    ASSERT_EQ(one.size(), four.size());
    EXPECT_GT(one.size(), 10'000u);
    for (size_t i = 0; i < one.size(); ++i) {
        ASSERT_EQ(one[i].photon, four[i].photon);
        ASSERT_EQ(one[i].power_w, four[i].power_w);
        ASSERT_EQ(one[i].photons, four[i].photons);
    }
}

TEST(Stratification, AMillionPhotonsOfTheCornellBoxTakeLessThan24Megabytes) {
    // With 256 cells along the longest side the dense grid of [Hoet 2014] takes 576 MB.
    const test::PhotonScene scene(make_builtin_scene("cornell-box"));
    PhotonTracing tracing;
    tracing.photons = 500'000;
    tracing.most_scatterings = 3;
    const PhotonTracer tracer(scene.scene, *scene.intersector, scene.emission, tracing);
    std::vector<ReflectedPhoton> photons;
    for (uint32_t pass = 0; photons.size() < 1'000'000; ++pass) {
        const TracedReflections traced = tracer.trace_reflected(1, pass, CancelToken{});
        ASSERT_FALSE(traced.photons.empty());
        photons.insert(photons.end(), traced.photons.begin(), traced.photons.end());
    }
    photons.resize(1'000'000);
    for (const uint32_t minimum : {1u, 2u}) {
        StratificationSettings settings;
        settings.bounds = scene.scene.bounds;
        settings.cells = 256;
        settings.minimum_photons = minimum;
        settings.splats_per_cell = 1;
        settings.representative = Representative::ByPower;
        uint64_t peak_bytes = 0;
        const std::vector<SplatSource> splats = stratify(photons, settings, 1, 0, peak_bytes);
        EXPECT_GE(peak_bytes, photons.size() * 8);
        EXPECT_LE(peak_bytes + splats.capacity() * sizeof(SplatSource), 24'000'000u) << splats.size() << " splats";
        EXPECT_GT(splats.size(), 100'000u);
        EXPECT_EQ(photons_of(splats), 1e6);
    }
}

}  // namespace
}  // namespace photond::stratification_test
