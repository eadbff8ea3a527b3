// The environment's maps against sums over all of it.

#include "renderer/methods/image_based_lighting/prefiltered_environment.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "renderer/core/rng.h"
#include "renderer/methods/image_based_lighting/environment_pyramid.h"
#include "renderer/transport/environment_sampling.h"
#include "tests/support/bsdf_quadrature.h"
#include "tests/support/environments.h"

namespace photond::prefiltered_environment_test {
namespace {

/// Of D(h) cos, about `axis`, over `rows` rows of cells; in double, by the formulas as they are printed.
dvec3 blurred_by_force(const EnvironmentSampler& sampler, const vec3& axis, double alpha, int rows) {
    dvec3 sum(0);
    double weights = 0;
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < 2 * rows; ++x) {
            const double polar = M_PI * (y + 0.5) / rows, azimuth = M_PI * (x + 0.5) / rows;
            const dvec3 l(std::sin(polar) * std::cos(azimuth), std::cos(polar), std::sin(polar) * std::sin(azimuth));
            const double cosine = glm::dot(l, dvec3(axis));
            if (cosine <= 0) continue;
            const double cos_h = glm::dot(glm::normalize(l + dvec3(axis)), dvec3(axis));
            const double d = alpha * alpha / (M_PI * std::pow(cos_h * cos_h * (alpha * alpha - 1) + 1, 2));
            const double weight = d * cosine * std::sin(polar);
            sum += weight * dvec3(sampler.radiance(vec3(l)));
            weights += weight;
        }
    return sum / weights;
}

vec3 direction_of(RandomStream& random) {
    const float z = 2 * random.next() - 1;
    return vec3(test::direction_at(static_cast<double>(z), static_cast<double>(random.next())));
}

/// The greatest error of the pyramid's sums, and of the maps', over the mean radiance about as many directions.
void expect_near_the_sums(Environment environment, double most_of_sums, double most_of_maps) {
    environment.rotation = 1;
    environment.scale = 2;
    const EnvironmentSampler sampler(environment);
    const EnvironmentPyramid pyramid(environment, sampler, 256);
    const PrefilteredEnvironment maps(environment, sampler, {.resolution = 64, .levels = 7});
    RandomStream random(5, RandomDomain::Test, 0, 0);
    double of_sums = 0, of_maps = 0;
    for (const float roughness : {0.15f, 0.25f, 0.5f, 1.0f})
        for (int i = 0; i < 12; ++i) {
            const vec3 axis = direction_of(random);
            const double alpha = static_cast<double>(sqr(roughness));
            const dvec3 truth = blurred_by_force(sampler, axis, alpha, 256);
            const dvec3 sum(pyramid.blurred(axis, sqr(roughness))), map(maps.radiance(axis, roughness));
            for (int c = 0; c < 3; ++c) {
                of_sums = std::max(of_sums, std::fabs(sum[c] / truth[c] - 1));
                of_maps = std::max(of_maps, std::fabs(map[c] / truth[c] - 1));
            }
        }
    std::printf("sums off by %.2f %%, maps by %.2f %%\n", 100 * of_sums, 100 * of_maps);
    EXPECT_LT(of_sums, most_of_sums);
    EXPECT_LT(of_maps, most_of_maps);
}

TEST(PrefilteredEnvironment, IsTheSumOverASky) { expect_near_the_sums(test::sky({64, 32}), 0.015, 0.05); }
TEST(PrefilteredEnvironment, IsTheSumOverASun) { expect_near_the_sums(test::sky_with_sun({64, 32}, 0.1f), 0.015, 0.1); }
TEST(PrefilteredEnvironment, IsTheSumOverAMapOfOddSize) { expect_near_the_sums(test::windows({37, 21}), 0.03, 0.1); }
TEST(PrefilteredEnvironment, IsTheSumOverAMapOfMoreTexelsThanCells) {
    expect_near_the_sums(test::sky_with_sun({1030, 515}), 0.015, 0.1);
}

TEST(PrefilteredEnvironment, TheRoughestIsTheIrradiance) {
    const Environment environment = test::sky_with_sun({64, 32}, 0.1f);
    const EnvironmentSampler sampler(environment);
    const PrefilteredEnvironment maps(environment, sampler, {.resolution = 64, .levels = 2});
    RandomStream random(6, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 20; ++i) {
        const vec3 normal = direction_of(random);
        const dvec3 truth = blurred_by_force(sampler, normal, 1, 256);
        EXPECT_NEAR(static_cast<double>(maps.reflected_by_white(normal).x), truth.x, 0.02 * truth.x);
        EXPECT_EQ(maps.reflected_by_white(normal), maps.radiance(normal, 1));
    }
}

TEST(PrefilteredEnvironment, TheSmoothestIsTheEnvironmentItself) {
    const Environment environment = test::sky({64, 32});
    const EnvironmentSampler sampler(environment);
    const PrefilteredEnvironment maps(environment, sampler, {.resolution = 64, .levels = 4});
    RandomStream random(8, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 20; ++i) {
        const vec3 direction = direction_of(random);
        EXPECT_EQ(maps.radiance(direction, 0), sampler.radiance(direction));
        EXPECT_NEAR(maps.radiance(direction, 0.05f).y, sampler.radiance(direction).y, 0.02f);
    }
}

TEST(PrefilteredEnvironment, NeitherBlackNorASingleTexelTroublesIt) {
    for (const float radiance : {0.0f, 3.0f}) {
        const Environment environment = test::environment_of({1, 1}, [&](const vec3&) { return Rgb(radiance); });
        const EnvironmentSampler sampler(environment);
        const PrefilteredEnvironment maps(environment, sampler, {.resolution = 64, .levels = 2});
        for (const float roughness : {0.01f, 0.3f, 1.0f})
            EXPECT_NEAR(maps.radiance({0, 1, 0}, roughness).x, radiance, 1e-4f);
    }
}

TEST(PrefilteredEnvironment, TakesTheBytesThatItSays) {
    const Environment environment = test::sky({64, 32});
    const EnvironmentSampler sampler(environment);
    for (const uint32_t levels : {2u, 9u}) {
        const PrefilterSettings settings{.resolution = 64, .levels = levels};
        EXPECT_EQ(PrefilteredEnvironment(environment, sampler, settings).nodes().size_bytes(),
                  PrefilteredEnvironment::bytes_for(settings));
    }
}

}  // namespace
}  // namespace photond::prefiltered_environment_test
