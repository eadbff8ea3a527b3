// Kernels against numerical integration over the disc.

#include "renderer/photons/kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "protocol/error.h"

namespace photond::kernel_test {
namespace {

std::vector<Kernel> kernels() {
    std::vector<Kernel> all;
    for (const KernelShape shape :
         {KernelShape::Constant, KernelShape::Cone, KernelShape::Gaussian, KernelShape::Epanechnikov})
        all.emplace_back(shape);
    for (const float k : {1.0f, 2.5f, 1e6f}) all.emplace_back(KernelShape::Cone, k);
    return all;
}

std::string name(const Kernel& kernel) {
    return "shape " + std::to_string(static_cast<int>(kernel.shape())) + ", k " + std::to_string(kernel.cone_k());
}

/// Integral of the kernel over the disc of radius q: Simpson's rule along the radius.
double integral(const Kernel& kernel, double q) {
    constexpr int kSteps = 2000;
    double sum = 0;
    for (int i = 0; i <= kSteps; ++i) {
        const double u = q * i / kSteps;
        const double value = 2 * 3.14159265358979323846 * u * double{kernel(static_cast<float>(u * u))};
        sum += value * (i == 0 || i == kSteps ? 1 : i % 2 ? 4 : 2);
    }
    return sum * q / (3 * kSteps);
}

TEST(Kernel, IntegratesToOneOverTheDisc) {
    for (const Kernel& kernel : kernels()) EXPECT_NEAR(integral(kernel, 1), 1, 1e-6) << name(kernel);
}

TEST(Kernel, MassWithinIsTheIntegralUpToThere) {
    for (const Kernel& kernel : kernels()) {
        for (const double q : {0.0, 0.01, 0.2, 0.5, 0.77, 0.99, 1.0})
            EXPECT_NEAR(double{kernel.mass_within(static_cast<float>(q))}, integral(kernel, q), 1e-6)
                << name(kernel) << " q " << q;
        EXPECT_EQ(kernel.mass_within(0.0f), 0.0f);
        EXPECT_EQ(kernel.mass_within(1.0f), 1.0f);
        EXPECT_EQ(kernel.mass_within(3.0f), 1.0f);
    }
}

TEST(Kernel, NeverNegativeAndNowhereRising) {
    for (const Kernel& kernel : kernels()) {
        for (int i = 1; i <= 1000; ++i) {
            const float q_sq = static_cast<float>(i) / 1000;
            EXPECT_GE(kernel(q_sq), -1e-7f) << name(kernel);
            EXPECT_LE(kernel(q_sq), kernel(q_sq - 1e-3f)) << name(kernel);
        }
    }
}

TEST(Kernel, ShapesAreThoseOfTheirSources) {
    EXPECT_FLOAT_EQ(Kernel(KernelShape::Constant)(0.3f), kInvPi);
    // [Jensen 1996]: (1 - q / k) / ((1 - 2 / (3 k)) pi).
    EXPECT_FLOAT_EQ(Kernel(KernelShape::Cone, 1.1f)(0.25f), (1 - 0.5f / 1.1f) / ((1 - 2 / 3.3f) * kPi));
    EXPECT_FLOAT_EQ(Kernel(KernelShape::Epanechnikov)(0.25f), 1.5f / kPi);
    // [Jensen 2001, Eq. 7.8], whatever its factor.
    const Kernel gaussian(KernelShape::Gaussian);
    const auto w = [](float q_sq) { return 1 - (1 - std::exp(-1.953f * q_sq / 2)) / (1 - std::exp(-1.953f)); };
    for (const float q_sq : {0.1f, 0.5f, 1.0f}) EXPECT_NEAR(gaussian(q_sq) / gaussian(0), w(q_sq), 1e-6f);
}

// A disc drawn over u in [0, 1) brings 1 / (pi disc^2) within itself. Its mass within q falls as u grows, so that the
// midpoints of n strata miss the mean by 1 / (2 n) at most; single precision adds little.
TEST(Kernel, IsTheMeanOfItsDiscs) {
    constexpr int kStrata = 20000;
    constexpr double kTolerance = 0.5 / kStrata + 2e-6;
    for (const Kernel& kernel : kernels()) {
        std::vector<double> discs;
        for (int i = 0; i < kStrata; ++i) {
            discs.push_back(double{kernel.sample_disc((static_cast<float>(i) + 0.5f) / kStrata)});
            EXPECT_GT(discs.back(), 0) << name(kernel);
            EXPECT_LE(discs.back(), 1) << name(kernel);
        }
        EXPECT_TRUE(std::is_sorted(discs.begin(), discs.end())) << name(kernel);
        for (const double q : {0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.98, 1.0}) {
            double mass = 0;
            for (const double disc : discs) mass += std::min(1.0, q * q / (disc * disc));
            EXPECT_NEAR(mass / kStrata, double{kernel.mass_within(static_cast<float>(q))}, kTolerance)
                << name(kernel) << " q " << q;
        }
        EXPECT_LE(kernel.sample_disc(0x1.fffffep-1f), 1);
        EXPECT_GT(kernel.sample_disc(0), 0);
    }
}

TEST(Kernel, LanesAgreeWithSingleNumbers) {
    for (const Kernel& kernel : kernels())
        for (int i = 0; i <= 1000; i += int(kLanes)) {
            FloatLanes q_sq;
            for (int lane = 0; lane < int(kLanes); ++lane) q_sq[size_t(lane)] = std::min(1.0f, float(i + lane) / 1000);
            const FloatLanes together = kernel(q_sq);
            for (size_t lane = 0; lane < kLanes; ++lane)
                EXPECT_NEAR(float{together[lane]}, kernel(float{q_sq[lane]}), 2e-6f)
                    << name(kernel) << " q^2 " << float{q_sq[lane]};
        }
}

TEST(Kernel, ACutConeIsRefused) {
    for (const float k : {0.999f, 0.0f, -1.0f, std::numeric_limits<float>::quiet_NaN()}) {
        try {
            const Kernel kernel(KernelShape::Cone, k);
            FAIL() << "accepted k = " << k;
        } catch (const Error& error) {
            EXPECT_EQ(error.code, ErrorCode::OutOfRange);
        }
    }
}

}  // namespace
}  // namespace photond::kernel_test
