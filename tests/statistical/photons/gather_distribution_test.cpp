// Gather rays by photons: the density is one, what is drawn follows it, and the estimate does not depend on it.
// Chance of a false alarm 1e-6 for the file's checks together.

#include "renderer/photons/gather_distribution.h"

#include <gtest/gtest.h>

#include "renderer/core/rng.h"
#include "tests/support/statistics.h"

namespace photond::gather_distribution_test {
namespace {

constexpr double kFalseAlarm = 1e-6;
constexpr size_t kChecks = 3;

/// Photons about the origin of the plane y = 0 that came from a narrow cone about `from`, and some from everywhere.
PhotonMap lit_from(const vec3& from) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    const Frame frame(glm::normalize(from));
    std::vector<Photon> photons;
    for (int i = 0; i < 400; ++i) {
        const vec3 position(random.next() - 0.5f, 0, random.next() - 0.5f);
        vec3 wi = sample_cosine_hemisphere(random.next_2d());
        wi = i % 4 ? frame.to_world(glm::normalize(vec3(0.1f * wi.x, 0.1f * wi.y, 1))) : vec3(wi.x, wi.z, wi.y);
        photons.push_back({position, PhotonPayload::make(Rgb(0.01f), wi, {0, 1, 0}, 1, false)});
    }
    return PhotonMap(std::move(photons), {.kind = PhotonSearch::Kind::Nearest, .nearest = 200, .radius_m = 10});
}

ShadingPoint floor_point() {
    ShadingPoint point;
    point.geometric_normal = {0, 1, 0};
    point.shading = Frame(vec3(0, 1, 0));
    return point;
}

TEST(GatherDistribution, DirectionsFollowTheirDensity) {
    Neighbours scratch;
    const GatherDistribution distribution(lit_from({1, 1, 0}), floor_point(), 10, scratch);
    ASSERT_FALSE(distribution.empty());
    const Bsdf bsdf = Bsdf::lambert({0, 0, 1}, Rgb(0.5f));
    const vec3 wo = glm::normalize(vec3(0.3f, 0.1f, 1));

    // Cells of cos and azimuth; the expected counts by a midpoint rule of the stated density.
    constexpr size_t kCos = 12, kAzimuth = 24, kSteps = 24, kSamples = 200'000;
    std::vector<double> expected(kCos * kAzimuth), observed(kCos * kAzimuth);
    double integral = 0;
    for (size_t i = 0; i < kCos * kSteps; ++i)
        for (size_t j = 0; j < kAzimuth * kSteps; ++j) {
            const float z = (float(i) + 0.5f) / (kCos * kSteps), r = std::sqrt(1 - z * z);
            const float phi = 2 * kPi * (float(j) + 0.5f) / (kAzimuth * kSteps);
            const vec3 wi(r * std::cos(phi), r * std::sin(phi), z);
            const double density = GatherDistribution::kPhotonShare * double(distribution.photon_pdf_sa(wi)) +
                                   (1 - GatherDistribution::kPhotonShare) * double(bsdf.evaluate(wo, wi).pdf_sa);
            const double mass = density * 2 * double(kPi) / double(kCos * kSteps * kAzimuth * kSteps);
            expected[i / kSteps * kAzimuth + j / kSteps] += mass * kSamples;
            integral += mass;
        }
    EXPECT_NEAR(integral, 1, 2e-3);
    RandomStream random(2, RandomDomain::Test, 0, 0);
    for (size_t i = 0; i < kSamples; ++i) {
        const float u_lobe = random.next();
        const GatherDistribution::Sample s = distribution.sample(bsdf, wo, u_lobe, random.next_2d());
        ASSERT_GT(s.pdf_sa, 0);
        const double density = GatherDistribution::kPhotonShare * double(distribution.photon_pdf_sa(s.wi)) +
                               (1 - GatherDistribution::kPhotonShare) * double(bsdf.evaluate(wo, s.wi).pdf_sa);
        EXPECT_NEAR(double(s.pdf_sa), density, 1e-4 * density);
        float phi = std::atan2(s.wi.y, s.wi.x);
        if (phi < 0) phi += 2 * kPi;
        const auto row = std::min(size_t(s.wi.z * kCos), kCos - 1);
        ++observed[row * kAzimuth + std::min(size_t(phi / (2 * kPi) * kAzimuth), kAzimuth - 1)];
    }
    EXPECT_GT(test::chi_square_probability(observed, expected), test::share_of_false_alarm(kFalseAlarm, kChecks));
}

TEST(GatherDistribution, TheEstimateStaysAndItsVarianceFalls) {
    Neighbours scratch;
    const vec3 from = glm::normalize(vec3(1, 1, 0));
    const GatherDistribution guided(lit_from(from), floor_point(), 10, scratch);
    const GatherDistribution plain(PhotonMap(), floor_point(), 10, scratch);
    ASSERT_TRUE(plain.empty());
    const Bsdf bsdf = Bsdf::lambert({0, 0, 1}, Rgb(0.5f));
    const vec3 wo(0, 0, 1), lamp = floor_point().shading.to_local(from);
    // Light from the cone the photons came from, on top of a dim sky: its integral by plain sampling of the sphere cap.
    const auto radiance = [&](const vec3& wi) { return glm::dot(wi, lamp) > 0.99f ? 100.0 : 0.1; };
    const auto estimate = [&](const GatherDistribution& distribution, uint64_t seed, test::RunningMean& samples) {
        RandomStream random(seed, RandomDomain::Test, 1, 0);
        for (int i = 0; i < 200'000; ++i) {
            const float u_lobe = random.next();
            const GatherDistribution::Sample s = distribution.sample(bsdf, wo, u_lobe, random.next_2d());
            samples.add(s.pdf_sa > 0 ? double(s.weight.x) * radiance(s.wi) : 0);
        }
    };
    test::RunningMean with, without;
    estimate(guided, 3, with);
    estimate(plain, 4, without);
    const double sigma = std::hypot(with.standard_error(), without.standard_error());
    EXPECT_LE(std::abs(with.mean() - without.mean()),
              test::two_sided_z(test::share_of_false_alarm(kFalseAlarm, kChecks)) * sigma);
    EXPECT_LE(sigma, 0.02 * without.mean()) << "too noisy to notice a defect";
    EXPECT_LT(with.variance(), 0.2 * without.variance());
}

TEST(GatherDistribution, PhotonsOfTheOtherSideAndOfLongerPathsDoNotCount) {
    std::vector<Photon> photons;
    for (int i = 0; i < 20; ++i) {
        const vec3 position(0.01f * float(i), 0, 0);
        photons.push_back({position, PhotonPayload::make(Rgb(1), {0, -1, 0}, {0, -1, 0}, 1, false)});
        photons.push_back({position, PhotonPayload::make(Rgb(1), {0, 1, 0}, {0, 1, 0}, 5, false)});
    }
    const PhotonMap map(std::move(photons), {.kind = PhotonSearch::Kind::Nearest, .nearest = 30, .radius_m = 1});
    Neighbours scratch;
    EXPECT_TRUE(GatherDistribution(map, floor_point(), 4, scratch).empty());
    EXPECT_FALSE(GatherDistribution(map, floor_point(), 5, scratch).empty());
}

}  // namespace
}  // namespace photond::gather_distribution_test
