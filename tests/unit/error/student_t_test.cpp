// Student's t against values that follow from closed forms and tables, and against itself.

#include "renderer/error/student_t.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace photond::student_t_test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(StudentT, TailsFollowTheirClosedForms) {
    for (const double t : {0.0, 0.01, 0.7, 1.0, 3.0, 40.0, 1e4, 1e8}) {
        const double one = t < 1 ? 1 - 2 / std::numbers::pi * std::atan(t) : 2 / std::numbers::pi * std::atan(1 / t);
        // 1 - t / sqrt(2 + t^2), without cancellation.
        const double root = std::sqrt(2 + t * t), two = 2 / (root * (root + t));
        EXPECT_NEAR(student_t_tails(t, 1) / one, 1, 1e-12) << t;
        EXPECT_NEAR(student_t_tails(t, 2) / two, 1, 1e-12) << t;
        EXPECT_EQ(student_t_tails(t, 2), student_t_tails(-t, 2));
        EXPECT_DOUBLE_EQ(student_t_tails(t, kInfinity), std::erfc(t / std::numbers::sqrt2));
    }
    EXPECT_EQ(student_t_tails(kInfinity, 3.5), 0);
    EXPECT_NEAR(student_t_tails(2, 1e6) / std::erfc(std::numbers::sqrt2), 1, 1e-5);
}

TEST(StudentT, QuantilesAreThoseOfTables) {
    // [Abramowitz and Stegun 1964, Table 26.10]
    EXPECT_NEAR(two_sided_student_t(0.9, 1), 6.314, 5e-4);
    EXPECT_NEAR(two_sided_student_t(0.95, 2), 4.303, 5e-4);
    EXPECT_NEAR(two_sided_student_t(0.95, 10), 2.228, 5e-4);
    EXPECT_NEAR(two_sided_student_t(0.998, 30), 3.385, 5e-4);
    EXPECT_NEAR(two_sided_student_t(0.9, kInfinity), 1.6448536269514722, 1e-9);
    EXPECT_EQ(two_sided_student_t(0, 4), 0);
}

TEST(StudentT, FractionalDegreesLieBetweenWholeOnes) {
    double last = two_sided_student_t(0.99, 1);
    for (double degrees = 1.25; degrees < 40; degrees += 0.25) {
        const double t = two_sided_student_t(0.99, degrees);
        EXPECT_LT(t, last) << degrees;
        EXPECT_NEAR(student_t_tails(t, degrees), 0.01, 1e-12) << degrees;
        last = t;
    }
    EXPECT_GT(two_sided_student_t(0.9, 0.5), two_sided_student_t(0.9, 1));
}

}  // namespace
}  // namespace photond::student_t_test
