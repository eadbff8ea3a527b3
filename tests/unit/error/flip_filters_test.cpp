#include "renderer/error/flip_filters.h"

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/error/flip.h"
#include "renderer/error/flip_features.h"
#include "tests/support/direct_flip.h"

namespace photond::flip_filters_test {
namespace {

constexpr double kPixelsPerDegree = kFlipPixelsPerDegree;
namespace direct = test::direct_flip;

double weight(const HalfFilter& half, int k, bool odd = false) {
    const auto distance = static_cast<size_t>(std::abs(k));
    return distance < half.size() ? (odd && k < 0 ? -1 : 1) * double{half[distance]} : 0.0;
}
double sum_of(const HalfFilter& half) {
    double sum = 0;
    for (int k = -int(half.size()); k <= int(half.size()); ++k) sum += weight(half, k);
    return sum;
}

TEST(FlipFilters, RadiiAndSums) {
    const FlipFilters filters = make_flip_filters(kPixelsPerDegree);
    // 3 sqrt(0.04 / (2 pi^2)) = 0.13505 degrees, 9.05 pixels; 3 x 0.041 degrees, 8.24 pixels.
    EXPECT_EQ(filters.blue_yellow[0].size(), 11u);
    EXPECT_EQ(filters.gaussian.size(), 10u);
    EXPECT_EQ(filters.edge.size(), 10u);
    EXPECT_EQ(filters.point.size(), 10u);
    EXPECT_EQ(filters.radius, 10u);
    EXPECT_NEAR(sum_of(filters.achromatic), 1, 1e-7);
    EXPECT_NEAR(sum_of(filters.red_green), 1, 1e-7);
    EXPECT_NEAR(sum_of(filters.gaussian), 1, 1e-7);
    const double first = sum_of(filters.blue_yellow[0]), second = sum_of(filters.blue_yellow[1]);
    EXPECT_NEAR(first * first + second * second, 1, 1e-6);
}

TEST(FlipFilters, DetectorsWeighBothSignsAlike) {
    for (const double pixels_per_degree : {1.0, 20.0, kPixelsPerDegree, 150.0}) {
        const FlipFilters filters = make_flip_filters(pixels_per_degree);
        double edge = 0, positive = 0, negative = 0;
        for (size_t k = 0; k < filters.edge.size(); ++k) {
            edge += double{filters.edge[k]};
            (filters.point[k] > 0 ? positive : negative) += (k == 0 ? 1 : 2) * double{filters.point[k]};
        }
        EXPECT_EQ(filters.edge[0], 0);
        EXPECT_NEAR(edge, 1, 1e-6) << pixels_per_degree;
        EXPECT_NEAR(positive, 1, 1e-6) << pixels_per_degree;
        EXPECT_NEAR(negative, -1, 1e-6) << pixels_per_degree;
    }
}

TEST(FlipFilters, WeightsFollowTheFormula) {
    const FlipFilters filters = make_flip_filters(kPixelsPerDegree);
    // Two pixels off, x^2 = (2 / 67.0206)^2 = 8.9053e-4 square degrees: exp(-pi^2 x^2 / b).
    EXPECT_NEAR(filters.achromatic[2] / filters.achromatic[0], std::exp(-9.8696044 * 8.9053e-4 / 0.0047), 1e-5);
    EXPECT_NEAR(filters.red_green[2] / filters.red_green[0], std::exp(-9.8696044 * 8.9053e-4 / 0.0053), 1e-5);
    EXPECT_NEAR(filters.blue_yellow[0][2] / filters.blue_yellow[0][0], std::exp(-9.8696044 * 8.9053e-4 / 0.04), 1e-5);
    EXPECT_NEAR(filters.blue_yellow[1][2] / filters.blue_yellow[1][0], std::exp(-9.8696044 * 8.9053e-4 / 0.025), 1e-5);
    // The two parts of the kernel at its centre are as a sqrt(pi / b): 34.1 sqrt(25 pi) to 13.5 sqrt(40 pi).
    const double ratio = filters.blue_yellow[0][0] / double{filters.blue_yellow[1][0]};
    EXPECT_NEAR(ratio * ratio, 34.1 * 5 / (13.5 * std::sqrt(40.0)), 1e-5);
    // Detectors, sigma = 2.74784 pixels: x g(x) and (x^2 / sigma^2 - 1) g(x).
    const double sigma2 = 2.747845 * 2.747845;
    EXPECT_NEAR(filters.edge[3] / filters.edge[1], 3 * std::exp(-(9 - 1) / (2 * sigma2)), 1e-5);
    EXPECT_NEAR(filters.point[1] / filters.point[0], (1 - 1 / sigma2) * std::exp(-1 / (2 * sigma2)), 1e-5);
    EXPECT_NEAR(filters.point[5] / filters.point[4],
                (25 / sigma2 - 1) / (16 / sigma2 - 1) * std::exp(-(25 - 16) / (2 * sigma2)), 1e-5);
}

TEST(FlipFilters, ProductsAreThePublishedKernels) {
    for (const double pixels_per_degree : {5.0, kPixelsPerDegree}) {
        const FlipFilters f = make_flip_filters(pixels_per_degree);
        const auto expect_kernel = [&](const direct::Kernel& kernel, const auto& product) {
            for (int y = -kernel.radius; y <= kernel.radius; ++y)
                for (int x = -kernel.radius; x <= kernel.radius; ++x)
                    EXPECT_NEAR(kernel.at(x, y), product(x, y), 3e-8) << x << ' ' << y;
        };
        const auto square = [](const HalfFilter& half) {
            return [&half](int x, int y) { return weight(half, x) * weight(half, y); };
        };
        expect_kernel(direct::contrast_kernel(0, pixels_per_degree), square(f.achromatic));
        expect_kernel(direct::contrast_kernel(1, pixels_per_degree), square(f.red_green));
        expect_kernel(direct::contrast_kernel(2, pixels_per_degree),
                      [&](int x, int y) { return square(f.blue_yellow[0])(x, y) + square(f.blue_yellow[1])(x, y); });
        // The published edge filter is the mirror image; only strengths are used.
        expect_kernel(direct::feature_kernel(false, false, pixels_per_degree),
                      [&](int x, int y) { return -weight(f.edge, x, true) * weight(f.gaussian, y); });
        expect_kernel(direct::feature_kernel(true, true, pixels_per_degree),
                      [&](int x, int y) { return weight(f.gaussian, x) * weight(f.point, y); });
    }
}

/// Strength of edge and of point at each pixel.
struct Strengths {
    Size2 size;
    std::vector<float> edge, point;

    Strengths(Size2 image_size, const std::vector<float>& image) : size(image_size) {
        const FlipFilters filters = make_flip_filters(kPixelsPerDegree);
        FeatureScan scan(filters, size);
        scan.start(image, std::nullopt, 0);
        std::vector<float> row(FeatureRow::floats(size.width));
        const size_t plane = FeatureRow::plane_floats(size.width);
        for (uint32_t y = 0; y < size.height; ++y) {
            scan.next_row(row.data());
            edge.insert(edge.end(), &row[3 * plane], &row[3 * plane] + size.width);
            point.insert(point.end(), &row[4 * plane], &row[4 * plane] + size.width);
        }
    }
    float edge_at(uint32_t x, uint32_t y) const { return edge[size_t{y} * size.width + x]; }
    float point_at(uint32_t x, uint32_t y) const { return point[size_t{y} * size.width + x]; }
};

/// White where `is_white`, black elsewhere.
template <class IsWhite>
std::vector<float> black_and_white(Size2 size, const IsWhite& is_white) {
    std::vector<float> image;
    for (uint32_t y = 0; y < size.height; ++y)
        for (uint32_t x = 0; x < size.width; ++x) image.insert(image.end(), 3, is_white(x, y) ? 1.0f : 0.0f);
    return image;
}

TEST(FlipFeatures, StepEdge) {
    const Size2 size{48, 30};
    const FlipFilters f = make_flip_filters(kPixelsPerDegree);
    const Strengths upright(size, black_and_white(size, [](uint32_t x, uint32_t) { return x >= 24; }));
    const Strengths level(size, black_and_white(size, [](uint32_t, uint32_t y) { return y >= 15; }));
    // All of one sign's weights on white, all of the other's on black: 1. The second derivative lacks, or has, the
    // whole of one side: half of what the centre weighs.
    for (const uint32_t off : {0u, 1u}) {
        EXPECT_NEAR(upright.edge_at(23 + off, 7), 1, 1e-6);
        EXPECT_NEAR(level.edge_at(7, 14 + off), 1, 1e-6);
        EXPECT_NEAR(upright.point_at(23 + off, 7), -f.point[0] / 2, 1e-6);
        EXPECT_NEAR(level.point_at(7, 14 + off), -f.point[0] / 2, 1e-6);
    }
    EXPECT_NEAR(upright.edge_at(25, 7), 1 - f.edge[1], 1e-6);  // one white weight meets white on the other side
    // Flat parts give exactly nothing.
    EXPECT_EQ(upright.edge_at(5, 5), 0);
    EXPECT_EQ(upright.point_at(5, 5), 0);
    EXPECT_EQ(upright.edge_at(40, 29), 0);
    EXPECT_EQ(upright.point_at(40, 29), 0);
}

TEST(FlipFeatures, LineAndPoint) {
    const Size2 size{40, 40};
    const FlipFilters f = make_flip_filters(kPixelsPerDegree);
    const Strengths line(size, black_and_white(size, [](uint32_t x, uint32_t) { return x == 20; }));
    EXPECT_NEAR(line.edge_at(20, 20), 0, 1e-7);
    EXPECT_NEAR(line.point_at(20, 20), -f.point[0], 1e-6);
    EXPECT_NEAR(line.edge_at(23, 20), f.edge[3], 1e-6);
    EXPECT_NEAR(line.point_at(25, 20), f.point[5], 1e-6);

    const Strengths dot(size, black_and_white(size, [](uint32_t x, uint32_t y) { return x == 20 && y == 20; }));
    EXPECT_NEAR(dot.edge_at(20, 20), 0, 1e-7);
    EXPECT_NEAR(dot.point_at(20, 20), -f.point[0] * f.gaussian[0] * std::sqrt(2.0), 1e-6);
    EXPECT_NEAR(dot.edge_at(22, 23), std::hypot(f.edge[2] * f.gaussian[3], f.gaussian[2] * f.edge[3]), 1e-6);
    EXPECT_EQ(dot.edge_at(30, 20), 0);
}

TEST(FlipFeatures, ARowDoesNotDependOnWhereTheScanBegan) {
    const Size2 size{21, 50};
    const FlipFilters filters = make_flip_filters(kPixelsPerDegree);
    std::vector<float> image(3 * size.pixels());
    for (size_t i = 0; i < image.size(); ++i) image[i] = static_cast<float>(i * 7919 % 1009) / 1009;
    FeatureScan from_top(filters, size), from_inside(filters, size);
    std::vector<float> a(FeatureRow::floats(size.width)), b(a.size());
    from_top.start(image, 1.5f, 0);
    from_inside.start(image, 1.5f, 33);
    for (uint32_t y = 0; y < size.height; ++y) {
        from_top.next_row(a.data());
        if (y < 33) continue;
        from_inside.next_row(b.data());
        EXPECT_EQ(a, b) << y;
    }
}

}  // namespace
}  // namespace photond::flip_filters_test
