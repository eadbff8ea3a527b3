// The blur against a direct sum in two dimensions, and what it must keep: means, constants, edges.

#include "renderer/gbuffer/indirect_blur.h"

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/core/rng.h"
#include "tests/support/threads.h"

namespace photond::indirect_blur_test {
namespace {

std::vector<Rgb> random_image(Size2 size, uint64_t seed) {
    RandomStream random(seed, RandomDomain::Test, 0, 0);
    std::vector<Rgb> image(size.pixels());
    for (Rgb& c : image) c = Rgb(random.next(), 3 * random.next(), -std::log(1 - random.next()));
    return image;
}

double gauss(int k, uint32_t width) {
    const double s = 0.25 * width;
    return std::exp(-0.5 * k * k / (s * s));
}

/// Square sum over the kernel's pixels that lie in the image, divided by their weights.
dvec3 direct_blur(const std::vector<Rgb>& image, Size2 size, uint32_t width, int x, int y) {
    const int radius = int(width / 2);
    dvec3 sum(0);
    double weights = 0;
    for (int j = std::max(0, y - radius); j <= std::min(int(size.height) - 1, y + radius); ++j) {
        for (int i = std::max(0, x - radius); i <= std::min(int(size.width) - 1, x + radius); ++i) {
            const double weight = gauss(i - x, width) * gauss(j - y, width);
            sum += weight * dvec3(image[size_t(j) * size.width + size_t(i)]);
            weights += weight;
        }
    }
    return sum / weights;
}

TEST(IndirectBlur, IsTheDirectSumInTwoDimensions) {
    for (const Size2 size : {Size2{37, 23}, Size2{300, 11}, Size2{5, 3}, Size2{1, 40}, Size2{40, 1}, Size2{1, 1}}) {
        for (const uint32_t width : {3u, 5u, 7u, 9u}) {
            const std::vector<Rgb> image = random_image(size, width);
            std::vector<Rgb> blurred = image;
            blur_layer(blurred, size, width, {});
            double worst = 0;
            for (int y = 0; y < int(size.height); ++y) {
                for (int x = 0; x < int(size.width); ++x) {
                    const dvec3 d =
                        dvec3(blurred[size_t(y) * size.width + size_t(x)]) - direct_blur(image, size, width, x, y);
                    worst = std::max({worst, std::abs(d.x), std::abs(d.y), std::abs(d.z)});
                }
            }
            EXPECT_LT(worst, 4e-6) << width << " across, " << size.width << "x" << size.height;
        }
    }
}

TEST(IndirectBlur, KeepsTheMeanOfWhatLiesInsideAndReachesAsFarAsItsWidth) {
    constexpr Size2 kSize{40, 30};
    for (const uint32_t width : {3u, 5u, 7u, 9u}) {
        std::vector<Rgb> image(kSize.pixels(), Rgb(0));
        image[15 * kSize.width + 20] = Rgb(1, 2, 4);
        blur_layer(image, kSize, width, {});
        dvec3 sum(0);
        for (uint32_t y = 0; y < kSize.height; ++y) {
            for (uint32_t x = 0; x < kSize.width; ++x) {
                const Rgb c = image[y * kSize.width + x];
                sum += dvec3(c);
                const bool within = std::max(std::abs(int(x) - 20), std::abs(int(y) - 15)) <= int(width / 2);
                EXPECT_EQ(c.x > 0, within) << x << ", " << y;
            }
        }
        EXPECT_NEAR(sum.x, 1, 1e-6);
        EXPECT_NEAR(sum.y, 2, 2e-6);
        EXPECT_NEAR(sum.z, 4, 4e-6);
    }
}

/// Normals and depths of random smooth surfaces.
struct Surfaces {
    std::vector<vec3> normal;
    std::vector<float> depth;
    BlurEdges edges() const { return {normal, depth}; }
};

Surfaces random_surfaces(Size2 size) {
    RandomStream random(5, RandomDomain::Test, 0, 0);
    Surfaces surfaces;
    for (size_t i = 0; i < size.pixels(); ++i) {
        surfaces.normal.push_back(glm::normalize(vec3(0.4f * random.next() - 0.2f, 0.4f * random.next() - 0.2f, 1)));
        surfaces.depth.push_back(2 + 0.05f * random.next());
    }
    return surfaces;
}

TEST(IndirectBlur, ConstantsStayWhateverTheEdges) {
    constexpr Size2 kSize{75, 40};
    const Surfaces surfaces = random_surfaces(kSize);
    const Rgb constant(0.1f, 1.7f, 31);
    for (const bool with_edges : {false, true}) {
        std::vector<Rgb> image(kSize.pixels(), constant);
        blur_layer(image, kSize, 9, with_edges ? surfaces.edges() : BlurEdges{});
        for (const Rgb& c : image)
            for (int k = 0; k < 3; ++k) ASSERT_NEAR(c[k] / constant[k], 1, 2e-6);
    }
}

/// One pass of the edge-aware blur in double precision, as the header states its weights.
std::vector<dvec3> direct_pass(const std::vector<dvec3>& image, Size2 size, uint32_t width, const Surfaces& surfaces,
                               bool rows) {
    const int radius = int(width / 2), w = int(size.width), h = int(size.height);
    std::vector<dvec3> out;
    for (int p = 0; p < w * h; ++p) {
        dvec3 sum(0);
        double weights = 0;
        for (int k = -radius; k <= radius; ++k) {
            const int along = (rows ? p % w : p / w) + k;
            if (along < 0 || along >= (rows ? w : h)) continue;
            const auto q = size_t(p + k * (rows ? 1 : w)), here = size_t(p);
            const double cosine = std::max(0.0, glm::dot(dvec3(surfaces.normal[here]), dvec3(surfaces.normal[q])));
            const double z = surfaces.depth[here], d = (z - double{surfaces.depth[q]}) / (0.02 * z);
            const double weight = k == 0 ? 1 : gauss(k, width) * std::pow(cosine, 32) * std::exp(-d * d);
            sum += weight * image[q];
            weights += weight;
        }
        out.push_back(sum / weights);
    }
    return out;
}

TEST(IndirectBlur, WeightsAreThoseStated) {
    constexpr Size2 kSize{83, 31};
    const Surfaces surfaces = random_surfaces(kSize);
    const std::vector<Rgb> image = random_image(kSize, 9);
    std::vector<dvec3> expected(image.begin(), image.end());
    expected = direct_pass(expected, kSize, 7, surfaces, true);
    expected = direct_pass(expected, kSize, 7, surfaces, false);
    std::vector<Rgb> blurred = image;
    blur_layer(blurred, kSize, 7, surfaces.edges());
    for (size_t i = 0; i < image.size(); ++i)
        for (int k = 0; k < 3; ++k) ASSERT_NEAR(double{blurred[i][k]}, expected[i][k], 3e-5);
}

/// An image whose left half holds one value, its right half another.
template <class Value>
std::vector<Value> halves(Size2 size, const Value& left, const Value& right) {
    std::vector<Value> values;
    for (uint32_t i = 0; i < size.pixels(); ++i) values.push_back(i % size.width < size.width / 2 ? left : right);
    return values;
}

TEST(IndirectBlur, StopsAtEdgesOfNormalsAndDepths) {
    // Left half black, right half white. Normals at right angles, then a step of depth, then sky beside a surface; each
    // of normals and depths also without the other.
    constexpr Size2 kSize{40, 20};
    const std::vector<Rgb> image = halves(kSize, Rgb(0), Rgb(1));
    const auto bent = halves(kSize, vec3(0, 0, 1), vec3(1, 0, 0)),
               opposite = halves(kSize, vec3(0, 0, 1), vec3(0, 0, -1));
    const auto flat = halves(kSize, vec3(0, 0, 1), vec3(0, 0, 1)), nothing = halves(kSize, vec3(0), vec3(0, 0, 1));
    const auto step = halves(kSize, 1.0f, 2.0f), even = halves(kSize, 1.0f, 1.0f), sky = halves(kSize, kInfinity, 1.0f);
    const auto not_a_number = halves(kSize, 1.0f, std::numeric_limits<float>::quiet_NaN());
    for (const BlurEdges& edges :
         {BlurEdges{bent, even}, BlurEdges{bent, {}}, BlurEdges{opposite, even}, BlurEdges{flat, step},
          BlurEdges{{}, step}, BlurEdges{nothing, sky}, BlurEdges{{}, sky}, BlurEdges{flat, not_a_number}}) {
        std::vector<Rgb> blurred = image;
        blur_layer(blurred, kSize, 9, edges);
        for (size_t i = 0; i < image.size(); ++i) ASSERT_NEAR(blurred[i].x, image[i].x, 1e-6) << i;
    }
    // Without an edge it does not stop; nor between two pixels of nothing.
    const auto all_nothing = halves(kSize, vec3(0), vec3(0));
    const auto all_sky = halves(kSize, kInfinity, kInfinity);
    std::vector<Rgb> plain = image;
    blur_layer(plain, kSize, 9, {});
    for (const BlurEdges& edges : {BlurEdges{flat, even}, BlurEdges{all_nothing, all_sky}}) {
        std::vector<Rgb> blurred = image;
        blur_layer(blurred, kSize, 9, edges);
        for (size_t i = 0; i < image.size(); ++i) ASSERT_NEAR(blurred[i].x, plain[i].x, 1e-5) << i;
    }
}

TEST(IndirectBlur, WhatIsNoNumberStaysWithinTheKernel) {
    constexpr Size2 kSize{70, 30};
    const Surfaces surfaces = random_surfaces(kSize);
    for (const bool with_edges : {false, true}) {
        for (const uint32_t width : {3u, 9u}) {
            std::vector<Rgb> image = random_image(kSize, 2);
            image[12 * kSize.width + 33].y = std::numeric_limits<float>::quiet_NaN();
            blur_layer(image, kSize, width, with_edges ? surfaces.edges() : BlurEdges{});
            for (int i = 0; i < int(image.size()); ++i) {
                const int dx = i % int(kSize.width) - 33, dy = i / int(kSize.width) - 12;
                const bool outside = std::max(std::abs(dx), std::abs(dy)) > int(width / 2);
                EXPECT_TRUE(std::isfinite(image[size_t(i)].x) && std::isfinite(image[size_t(i)].z));
                EXPECT_TRUE(!outside || std::isfinite(image[size_t(i)].y)) << dx << ", " << dy;
            }
        }
    }
}

TEST(IndirectBlur, IsTheSameForAnyNumberOfThreads) {
    constexpr Size2 kSize{129, 67};
    const Surfaces surfaces = random_surfaces(kSize);
    for (const bool with_edges : {false, true}) {
        const auto blurred = [&](int threads) {
            return test::on_threads(threads, [&] {
                std::vector<Rgb> image = random_image(kSize, 4);
                blur_layer(image, kSize, 9, with_edges ? surfaces.edges() : BlurEdges{});
                return image;
            });
        };
        const std::vector<Rgb> one = blurred(1);
        EXPECT_EQ(one, blurred(4));
    }
}

}  // namespace
}  // namespace photond::indirect_blur_test
