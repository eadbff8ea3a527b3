// Choosing lights keeps the sum over all of them, whoever answers for V; by how much the noise falls for it.

#include "renderer/many_lights/vpl_choice.h"

#include <gtest/gtest.h>

#include "tests/support/many_vpls.h"
#include "tests/support/statistics.h"

namespace photond::vpl_choice_test {
namespace {

using test::exact_irradiance;
using test::random_vpls;

constexpr float kClampSq = 0.01f;

/// Points in a room of 5 m, some on its floor, a few not there; of the lanes that are left neighbours lie together.
ChoicePoints random_points(uint64_t seed, std::vector<vec3>& positions, std::vector<vec3>& normals) {
    RandomStream random(seed, RandomDomain::Test, 0, 2);
    const vec3 about = 4.0f * (vec3(random.next(), random.next(), random.next()) - 0.5f);
    const vec3 facing = test::random_direction(random);
    Vec3Array position, normal;
    alignas(kLaneAlignment) LaneFloats there;
    ChoicePoints points;
    for (size_t lane = 0; lane < kLanes; ++lane) {
        positions.push_back(about + 0.3f * test::random_direction(random));
        normals.push_back(glm::normalize(facing + 0.3f * test::random_direction(random)));
        if (lane == 1) normals.back() = vec3(0);
        position.set(lane, positions.back());
        normal.set(lane, normals.back());
        there[lane] = lane == 2 ? 0.0f : 1.0f;
        points.most_scatterings[lane] = lane == 3 ? 1 : 255;
        points.general[lane] = lane == 4;
    }
    points.receivers = {position.load(), normal.load(), FloatLanes(there, std::experimental::vector_aligned)};
    return points;
}

/// An answer of V for each pair, the same every time.
bool seen(size_t lane, uint32_t vpl) { return hash32(vpl * 7919 + static_cast<uint32_t>(lane)) % 3 != 0; }

/// Sums of chosen lights over many passes against the sum over all. Of most points a defect of `noticed` of that sum
/// would be seen.
void expect_exact_means(VplChooser& chooser, const std::vector<Vpl>& vpls, uint64_t seed, double noticed) {
    constexpr size_t kPasses = 4000, kPointSets = 4;
    constexpr double kFalseAlarm = 1e-6;
    chooser.assign(vpls);
    const double z = test::two_sided_z(test::share_of_false_alarm(kFalseAlarm, kPointSets * kLanes));
    VplChooser::Scratch scratch;
    size_t checked = 0, sharp = 0;
    for (size_t set = 0; set < kPointSets; ++set) {
        std::vector<vec3> positions, normals;
        ChoicePoints points = random_points(seed + set, positions, normals);
        double exact[kLanes] = {};
        const auto light_of = [&](size_t lane, uint32_t i) {
            const Vpl& vpl = vpls[i];
            if (!seen(lane, i) || vpl.scatterings > points.most_scatterings[lane]) return 0.0;
            return double(exact_irradiance(vpl, positions[lane], normals[lane], kClampSq).y);
        };
        for (size_t lane = 0; lane < kLanes; ++lane)
            for (uint32_t i = 0; i < vpls.size(); ++i) exact[lane] += light_of(lane, i);
        test::RunningMean means[kLanes];
        for (uint32_t pass = 0; pass < kPasses; ++pass) {
            for (size_t lane = 0; lane < kLanes; ++lane)
                points.key[lane] = hash32(pass * uint32_t{kLanes} + static_cast<uint32_t>(lane) + 1);
            chooser.choose(points, kClampSq, scratch);
            for (size_t lane = 0; lane < kLanes; ++lane) {
                double sum = 0;
                for (const ChosenVpl& chosen : scratch.chosen[lane])
                    sum += double{chosen.weight} * light_of(lane, chosen.vpl);
                means[lane].add(sum);
            }
        }
        for (size_t lane = 0; lane < kLanes; ++lane) {
            SCOPED_TRACE("point " + std::to_string(lane) + " of set " + std::to_string(set));
            if (!(points.receivers.there[lane] > 0)) {
                EXPECT_TRUE(scratch.chosen[lane].empty());
                continue;
            }
            // Systematic samples of one kind of light may have no variance at all but rounding's.
            const double half_width = z * means[lane].standard_error() + 1e-5 * exact[lane];
            EXPECT_NEAR(means[lane].mean(), exact[lane], half_width);
            ++checked;
            if (half_width <= noticed * exact[lane]) ++sharp;
        }
    }
    EXPECT_GT(2 * sharp, checked) << "too noisy to notice a defect";
}

TEST(VplChoice, ResampledLightsHaveTheSumOfAll) {
    ResampledVpls eight(8), one(1);
    expect_exact_means(eight, random_vpls(300, 1, 0), 10, 0.05);
    expect_exact_means(one, random_vpls(300, 2, 0), 20, 0.2);
    ResampledVpls more_than_lights(64);
    expect_exact_means(more_than_lights, random_vpls(5, 3, 0), 30, 0.05);
}

TEST(VplChoice, LightcutsHaveTheSumOfAll) {
    for (const uint32_t size : {1u, 16u, 64u}) {
        LightcutVpls cut(size);
        expect_exact_means(cut, random_vpls(300, 4 + size, 0), 40 + size, size > 1 ? 0.1 : 1);
    }
}

TEST(VplChoice, LightsThatAreNotLambertAreNotLeftOut) {
    const std::vector<Vpl> vpls = random_vpls(300, 5, 0.3f);
    // Their share of the sum is what a reflector of albedo 1 would send: exact_irradiance() takes them for that here.
    LightcutVpls cut(32);
    expect_exact_means(cut, vpls, 60, 0.2);
    ResampledVpls resampled(8);
    expect_exact_means(resampled, vpls, 70, 0.2);
}

TEST(VplChoice, ACutOfAllLightsIsTheSumItself) {
    const std::vector<Vpl> vpls = random_vpls(60, 6, 0);
    LightcutVpls cut(64);
    cut.assign(vpls);
    std::vector<vec3> positions, normals;
    ChoicePoints points = random_points(80, positions, normals);
    std::fill(std::begin(points.key), std::end(points.key), 1u);
    VplChooser::Scratch scratch;
    cut.choose(points, kClampSq, scratch);
    for (size_t lane = 0; lane < kLanes; ++lane) {
        if (!(points.receivers.there[lane] > 0)) continue;
        double sum = 0, exact = 0;
        for (const ChosenVpl& chosen : scratch.chosen[lane]) {
            EXPECT_EQ(chosen.weight, 1);
            sum += double(exact_irradiance(vpls[chosen.vpl], positions[lane], normals[lane], kClampSq).y);
        }
        for (const Vpl& vpl : vpls) exact += double(exact_irradiance(vpl, positions[lane], normals[lane], kClampSq).y);
        EXPECT_NEAR(sum, exact, 1e-5 * exact);
    }
}

TEST(VplChoice, OneLightAndNone) {
    LightcutVpls cut(64);
    ResampledVpls resampled(8);
    std::vector<vec3> positions, normals;
    ChoicePoints points = random_points(90, positions, normals);
    std::fill(std::begin(points.key), std::end(points.key), 7u);
    VplChooser::Scratch scratch;
    std::vector<Vpl> one = random_vpls(1, 7, 0);
    one[0].position = positions[0] + 2.0f * normals[0];
    one[0].normal = -normals[0];
    one[0].scatterings = 1;
    for (VplChooser* chooser : {static_cast<VplChooser*>(&cut), static_cast<VplChooser*>(&resampled)}) {
        chooser->assign({});
        chooser->choose(points, kClampSq, scratch);
        for (const auto& chosen : scratch.chosen) EXPECT_TRUE(chosen.empty());
        chooser->assign(one);
        chooser->choose(points, kClampSq, scratch);
        ASSERT_EQ(scratch.chosen[0].size(), 1u);
        EXPECT_EQ(scratch.chosen[0][0].vpl, 0u);
        EXPECT_NEAR(scratch.chosen[0][0].weight, 1, 1e-5);
    }
}

TEST(VplChoice, ManyLightsAtOnePlace) {
    std::vector<Vpl> vpls = random_vpls(500, 8, 0);
    for (Vpl& vpl : vpls) vpl.position = vec3(0.1f, 0.2f, 2.4f);
    LightcutVpls cut(16);
    expect_exact_means(cut, vpls, 100, 0.2);
    ResampledVpls resampled(8);
    expect_exact_means(resampled, vpls, 110, 0.05);
}

/// At the same number of questions, cuts and resampling know more than a random subset does.
TEST(VplChoice, NoiseFallsWell) {
    const std::vector<Vpl> vpls = random_vpls(100'000, 9, 0);
    std::vector<vec3> positions, normals;
    ChoicePoints points = random_points(121, positions, normals);
    VplChooser::Scratch scratch;
    double exact[kLanes] = {}, of_subset[kLanes] = {};
    constexpr uint32_t kAsked = 32;
    for (size_t lane = 0; lane < kLanes; ++lane) {
        double squares = 0;
        for (const Vpl& vpl : vpls) {
            const double light = double(exact_irradiance(vpl, positions[lane], normals[lane], kClampSq).y) *
                                 (vpl.scatterings <= points.most_scatterings[lane] ? 1 : 0);
            exact[lane] += light, squares += light * light;
        }
        // Of kAsked lights drawn evenly: n/k times their sum.
        of_subset[lane] = (double(vpls.size()) * squares - exact[lane] * exact[lane]) / kAsked;
    }
    LightcutVpls cut(kAsked);
    ResampledVpls resampled(kAsked);
    for (VplChooser* chooser : {static_cast<VplChooser*>(&cut), static_cast<VplChooser*>(&resampled)}) {
        chooser->assign(vpls);
        test::RunningMean means[kLanes];
        for (uint32_t pass = 0; pass < 200; ++pass) {
            for (size_t lane = 0; lane < kLanes; ++lane)
                points.key[lane] = hash32(pass * uint32_t{kLanes} + static_cast<uint32_t>(lane) + 1);
            chooser->choose(points, kClampSq, scratch);
            for (size_t lane = 0; lane < kLanes; ++lane) {
                double sum = 0;
                for (const ChosenVpl& chosen : scratch.chosen[lane])
                    if (vpls[chosen.vpl].scatterings <= points.most_scatterings[lane])
                        sum += double{chosen.weight} *
                               double(exact_irradiance(vpls[chosen.vpl], positions[lane], normals[lane], kClampSq).y);
                means[lane].add(sum);
            }
        }
        for (size_t lane = 0; lane < kLanes; ++lane) {
            if (!(points.receivers.there[lane] > 0)) continue;
            EXPECT_LT(means[lane].variance(), 0.5 * of_subset[lane]) << "point " << lane;
        }
    }
}

}  // namespace
}  // namespace photond::vpl_choice_test
