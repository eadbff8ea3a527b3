// Stratified splats carry, on the mean, the power that the photons carried, wherever they carried it: choosing at
// random and by power are unbiased in each channel; what the thesis proposes besides is not, and is seen not to be.

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "renderer/methods/photon_splatting/stratification.h"
#include "tests/support/statistics.h"

namespace photond::stratification_bias_test {
namespace {

using test::RunningMean;
using test::share_of_false_alarm;
using test::two_sided_z;

constexpr double kFalseAlarm = 1e-6;  // chance that some other seeds fail a test without a defect
constexpr uint32_t kPasses = 4000;

/// What is measured of splats: power by channel, each times a weight of its photon's (as a receiver would weigh it).
struct Measure {
    std::vector<double> weight;  // by photon

    dvec3 of_photons(const std::vector<ReflectedPhoton>& photons) const {
        dvec3 sum(0);
        for (size_t i = 0; i < photons.size(); ++i) sum += weight[i] * dvec3(photons[i].power_w);
        return sum;
    }
    dvec3 of_splats(const std::vector<SplatSource>& splats) const {
        dvec3 sum(0);
        for (const SplatSource& splat : splats) sum += weight[splat.photon] * dvec3(splat.power_w);
        return sum;
    }
};

/// Photons whose colour depends on where they lie and which way they leave: what biases a choice that ignores it.
std::vector<ReflectedPhoton> coloured_photons(size_t count, const Bounds3& box) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    std::vector<ReflectedPhoton> photons(count);
    for (ReflectedPhoton& photon : photons) {
        const vec3 u(random.next(), random.next(), random.next());
        photon.position = box.min + box.diagonal() * u;
        photon.direction = glm::normalize(u - 0.5f);
        photon.power_w = std::exp(2 * random.next()) * Rgb(u.x * u.x, random.next() < 0.1f ? 1.0f : 0.0f, 1 - u.x);
    }
    return photons;
}

/// Measures of some passes, by channel; passes are independent, as their shifts and choices are.
std::array<RunningMean, 3> measure(const std::vector<ReflectedPhoton>& photons, const StratificationSettings& settings,
                                   const Measure& measure) {
    std::array<RunningMean, 3> means;
    for (uint32_t pass = 0; pass < kPasses; ++pass) {
        uint64_t peak_bytes = 0;
        const dvec3 measured = measure.of_splats(stratify(photons, settings, 1, pass, peak_bytes));
        for (int c = 0; c < 3; ++c) means[size_t(c)].add(measured[c]);
    }
    return means;
}

Measure by_position(const std::vector<ReflectedPhoton>& photons) {
    Measure measure;
    for (const ReflectedPhoton& photon : photons) measure.weight.push_back(std::exp(double{photon.position.x}));
    return measure;
}

struct Case {
    Representative representative;
    uint32_t splats, minimum_photons;
};

TEST(StratificationBias, AtRandomAndByPowerThereIsNoneInAnyChannel) {
    const Bounds3 box{vec3(0), vec3(2)};
    const std::vector<ReflectedPhoton> photons = coloured_photons(300, box);
    const Measure measured = by_position(photons);
    const dvec3 exact = measured.of_photons(photons);
    std::vector<Case> cases;
    for (const Representative representative : {Representative::Random, Representative::ByPower})
        for (const uint32_t splats : {1u, 3u})
            for (const uint32_t minimum : {1u, 4u}) cases.push_back({representative, splats, minimum});
    const double z = two_sided_z(share_of_false_alarm(kFalseAlarm, 3 * cases.size()));
    for (const Case& c : cases) {
        // Photons on a part of the box, too: those outside splat alone.
        const StratificationSettings settings{{vec3(0), vec3(1.7f)}, 4, c.minimum_photons, c.splats, c.representative};
        const std::array<RunningMean, 3> means = measure(photons, settings, measured);
        for (int k = 0; k < 3; ++k) {
            const RunningMean& mean = means[size_t(k)];
            const double half_width = z * mean.standard_error();
            EXPECT_NEAR(mean.mean(), exact[k], half_width)
                << "representative " << int(c.representative) << ", " << c.splats << " splats, channel " << k;
            EXPECT_LT(half_width, 0.08 * exact[k]) << "too noisy to notice a defect";
        }
    }
}

TEST(StratificationBias, ACellOfTwoColoursKeepsBothOnTheMean) {
    // Red photons and blue ones that a receiver weighs differently. By power each splat has the colour of the photon
    // chosen, and the means are right; the cell's summed RGB with one photon's place and direction lights red receivers
    // blue, and is far off when the same photon is chosen each time.
    std::vector<ReflectedPhoton> photons(10);
    Measure measured;
    for (size_t i = 0; i < photons.size(); ++i) {
        const bool red = i < 7;
        photons[i].position = vec3(1, red ? 1 : 1.001f, 1);
        photons[i].direction = red ? vec3(1, 0, 0) : vec3(0, 1, 0);
        photons[i].power_w = red ? Rgb(1, 0.25f, 0.125f) : Rgb(0.125f, 0.25f, 3);
        measured.weight.push_back(red ? 1 : 0.1);
    }
    const dvec3 exact = measured.of_photons(photons);
    const double z = two_sided_z(share_of_false_alarm(kFalseAlarm, 6));
    for (const Representative representative : {Representative::Random, Representative::ByPower}) {
        const StratificationSettings settings{{vec3(0), vec3(2)}, 2, 10, 1, representative};
        const std::array<RunningMean, 3> means = measure(photons, settings, measured);
        for (int k = 0; k < 3; ++k) {
            const double half_width = z * means[size_t(k)].standard_error();
            EXPECT_NEAR(means[size_t(k)].mean(), exact[k], half_width) << "channel " << k;
            EXPECT_LT(half_width, 0.15 * exact[k]) << "too noisy to notice a defect";
        }
    }
    for (const Representative representative : {Representative::ClosestToMean, Representative::DominantDirection}) {
        const StratificationSettings settings{{vec3(0), vec3(2)}, 2, 10, 1, representative};
        const std::array<RunningMean, 3> means = measure(photons, settings, measured);
        EXPECT_GT(std::abs(means[2].mean() - exact.z), 0.4 * exact.z) << "the test could see no bias at all";
    }
}

TEST(StratificationBias, PhotonsAreChosenAsOftenAsTheyShould) {
    // One cell; counts of choices over independent passes against shares of the power, by chi-square.
    const std::vector<ReflectedPhoton> photons = coloured_photons(40, {vec3(1), vec3(1)});
    double power = 0;
    for (const ReflectedPhoton& p : photons) power += double{mean(p.power_w)};
    for (const Representative representative : {Representative::Random, Representative::ByPower}) {
        const StratificationSettings settings{{vec3(0), vec3(2)}, 2, 1, 1, representative};
        std::vector<double> chosen(photons.size()), expected;
        for (uint32_t pass = 0; pass < 40'000; ++pass) {
            uint64_t peak_bytes = 0;
            ++chosen[stratify(photons, settings, 1, pass, peak_bytes).at(0).photon];
        }
        for (const ReflectedPhoton& p : photons)
            expected.push_back(40'000 *
                               (representative == Representative::Random ? 1.0 / 40 : mean(p.power_w) / power));
        EXPECT_GT(test::chi_square_probability(chosen, expected), 0.5 * kFalseAlarm);
    }
}

}  // namespace
}  // namespace photond::stratification_bias_test
