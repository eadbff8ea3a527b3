// Maps from the unit square have the densities they state (chi-square), and weights of multiple importance sampling sum
// to one.

#include "renderer/transport/sampling.h"

#include <gtest/gtest.h>

#include <functional>

#include "renderer/core/rng.h"
#include "renderer/transport/mis.h"
#include "tests/support/statistics.h"

namespace photond::sampling_test {
namespace {

// A million points into 16 x 16 cells of equal probability: 1 % of the points moved from one half of the square to the
// other adds 400 to a statistic of mean 255, deviation 23.
double equal_cells_probability(const std::function<vec2(vec2)>& to_unit_square) {
    constexpr int kDraws = 1'000'000;
    RandomStream random(1, RandomDomain::Test, 0, 0);
    std::vector<double> counts(256, 0);
    for (int i = 0; i < kDraws; ++i) {
        const vec2 p = to_unit_square(random.next_2d());
        const auto cell = [](float x) { return static_cast<size_t>(std::clamp(16 * x, 0.0f, 15.0f)); };
        ++counts[16 * cell(p.x) + cell(p.y)];
    }
    return test::chi_square_probability(counts, std::vector<double>(256, kDraws / 256.0));
}

float turn(float x, float y) { return 0.5f + std::atan2(y, x) / (2 * kPi); }

TEST(Sampling, DiskAndHemisphereAndTriangleAreUniformInTheirMeasures) {
    const double share = test::share_of_false_alarm(1e-6, 3);
    EXPECT_GT(equal_cells_probability([](vec2 u) {
                  const vec2 p = sample_unit_disk(u);
                  return vec2(glm::dot(p, p), turn(p.x, p.y));
              }),
              share);
    EXPECT_GT(equal_cells_probability([](vec2 u) {
                  const vec3 w = sample_cosine_hemisphere(u);
                  return vec2(1 - w.z * w.z, turn(w.x, w.y));
              }),
              share);
    EXPECT_GT(equal_cells_probability([](vec2 u) {
                  const vec2 b = sample_triangle(u);  // area below b.x = const is 1 - (1 - b.x)^2
                  return vec2(1 - sqr(1 - b.x), b.x < 1 ? b.y / (1 - b.x) : 0.0f);
              }),
              share);
}

TEST(Sampling, EdgesOfTheSquareStayInside) {
    const float last = 0x1.fffffep-1f;
    for (const float x : {0.0f, 0.25f, 0.5f, last})
        for (const float y : {0.0f, 0.25f, 0.5f, last}) {
            const vec3 w = sample_cosine_hemisphere({x, y});
            EXPECT_GT(w.z, 0);
            EXPECT_NEAR(glm::length(w), 1, 1e-6);
            const vec2 b = sample_triangle({x, y});
            EXPECT_TRUE(b.x >= 0 && b.y >= 0 && b.x + b.y <= 1) << b.x << " " << b.y;
        }
}

TEST(Mis, WeightsOfBothTechniquesSumToOne) {
    const float tiny = 1e-30f, huge = 1e30f;
    for (const float a : {tiny, 0.1f, 1.0f, 7.0f, huge})
        for (const float b : {tiny, 0.1f, 1.0f, 7.0f, huge}) {
            EXPECT_NEAR(power_heuristic(a, b) + power_heuristic(b, a), 1, 1e-6);
            EXPECT_NEAR(balance_heuristic(a, b) + balance_heuristic(b, a), 1, 1e-6);
        }
    EXPECT_EQ(power_heuristic(0, 0), 0);
    EXPECT_EQ(power_heuristic(0, 1), 0);
    EXPECT_EQ(power_heuristic(1, 0), 1);
    EXPECT_FLOAT_EQ(power_heuristic(1, 2), 0.2f);
}

TEST(Mis, AreaDensityBecomesSolidAngleDensity) {
    // A disc of radius r at distance d facing the viewer under 60 degrees: 1/area over the small solid angle
    // area cos / d^2.
    EXPECT_NEAR(area_to_solid_angle_pdf(4.0f, 9.0f, -0.5f), 4 * 9 / 0.5, 1e-4);
}

}  // namespace
}  // namespace photond::sampling_test
