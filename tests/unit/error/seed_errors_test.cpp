// seed_errors() against its definition, written down value by value.

#include "renderer/error/seed_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "renderer/core/rng.h"

namespace photond::seed_errors_test {
namespace {

constexpr Size2 kSize{19, 7};  // no whole number of runs or lanes

struct Images {
    std::vector<float> u, v;
    std::vector<std::vector<float>> films;
};

Images random_images(size_t films, float reference_noise) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    Images images{std::vector<float>(3 * kSize.pixels()), std::vector<float>(3 * kSize.pixels()), {}};
    for (float& value : images.u) value = 1 + reference_noise * random.next();
    for (float& value : images.v) value = 1 + reference_noise * random.next();
    for (size_t i = 0; i < films; ++i) {
        std::vector<float>& film = images.films.emplace_back(3 * kSize.pixels());
        for (float& value : film) value = 0.5f + 2 * random.next();
    }
    return images;
}

/// Mean over i != j of mean (A_i - U)(A_j - V) / D, and of the films' variance; values for which D is 0 are left out.
std::pair<double, double> by_definition(const Images& images, const std::vector<double>& divisors) {
    double products = 0, variance = 0;
    size_t count = 0;
    const auto k = static_cast<double>(images.films.size());
    for (size_t value = 0; value < images.u.size(); ++value) {
        if (divisors[value] == 0) continue;
        ++count;
        double mean = 0;
        for (const auto& film : images.films) mean += double{film[value]} / k;
        for (size_t i = 0; i < images.films.size(); ++i) {
            variance += std::pow(double{images.films[i][value]} - mean, 2) / (k - 1) / divisors[value];
            for (size_t j = 0; j < images.films.size(); ++j)
                if (i != j)
                    products += (double{images.films[i][value]} - double{images.u[value]}) *
                                (double{images.films[j][value]} - double{images.v[value]}) / (k * (k - 1)) /
                                divisors[value];
        }
    }
    return {products / static_cast<double>(count), variance / static_cast<double>(count)};
}

TEST(SeedErrors, FollowTheirDefinition) {
    for (const size_t films : {2, 3, 6}) {
        const Images images = random_images(films, 0.5f);
        const CrossMeter references(kSize, images.u, images.v);
        const SeedErrors errors = seed_errors(references, images.films);
        const auto [bias, variance] = by_definition(images, std::vector<double>(images.u.size(), 1));
        EXPECT_NEAR(errors.mse.value().squared_bias, bias, 1e-6);
        EXPECT_NEAR(errors.mse->variance, variance, 1e-6);
        EXPECT_EQ(errors.left_out, 0u);
        EXPECT_EQ(errors.mse->variance_interval.has_value(), films > 2);
        EXPECT_LT(errors.mse->squared_bias_interval.least, bias);
        EXPECT_GT(errors.mse->squared_bias_interval.greatest, bias);

        ASSERT_EQ(errors.denominators, Denominators::Neighbours);
        std::vector<double> divisors;
        for (const float weight : references.weights())
            divisors.push_back(references.unit() * references.unit() / double{weight});
        const auto [relative_bias, relative_variance] = by_definition(images, divisors);
        EXPECT_NEAR(errors.relative_mse.value().squared_bias, relative_bias, 1e-6);
        EXPECT_NEAR(errors.relative_mse->variance, relative_variance, 1e-6);
    }
}

TEST(SeedErrors, OfTwoImagesTheIntervalIsStudentsT) {
    // Without reference noise: t of one degree times |<e, e_1 - e_2>|.
    Images images = random_images(2, 0);
    const SeedErrors errors = seed_errors(CrossMeter(kSize, images.u, images.v), images.films);
    double product = 0;
    for (size_t i = 0; i < images.u.size(); ++i) {
        const double a = double{images.films[0][i]} - 1, b = double{images.films[1][i]} - 1;
        product += (a + b) / 2 * (a - b) / static_cast<double>(images.u.size());
    }
    const Interval& interval = errors.mse.value().squared_bias_interval;
    EXPECT_NEAR((interval.greatest - interval.least) / 2 / std::fabs(product), 6.31, 0.15);  // by 16 cases
}

TEST(SeedErrors, ImagesWithoutNoiseHaveBiasAlone) {
    const std::vector<float> reference(3 * kSize.pixels(), 2), film(3 * kSize.pixels(), 3);
    for (const size_t films : {2, 4}) {
        const std::vector<std::vector<float>> images(films, film);
        const SeedError error = seed_errors(CrossMeter(kSize, reference, reference), images).mse.value();
        EXPECT_NEAR(error.squared_bias, 1, 1e-6);
        EXPECT_NEAR(error.squared_bias_interval.least, 1, 1e-6);
        EXPECT_NEAR(error.squared_bias_interval.greatest, 1, 1e-6);
        EXPECT_NEAR(error.variance, 0, 1e-12);
    }
}

TEST(SeedErrors, LeaveOutWhatIsNotFiniteInAny) {
    Images images = random_images(3, 0.5f);
    std::vector<double> divisors(images.u.size(), 1);
    images.films[1][5] = std::numeric_limits<float>::quiet_NaN();
    images.films[2][100] = std::numeric_limits<float>::infinity();
    images.v[200] = -std::numeric_limits<float>::infinity();
    for (const size_t value : {5, 100, 200}) divisors[value] = 0;
    const SeedErrors errors = seed_errors(CrossMeter(kSize, images.u, images.v), images.films);
    const auto [bias, variance] = by_definition(images, divisors);
    EXPECT_EQ(errors.left_out, 3u);
    EXPECT_NEAR(errors.mse.value().squared_bias, bias, 1e-6);
    EXPECT_NEAR(errors.mse->variance, variance, 1e-6);
    images.films[0].assign(images.u.size(), std::numeric_limits<float>::quiet_NaN());
    EXPECT_FALSE(seed_errors(CrossMeter(kSize, images.u, images.v), images.films).mse);
    const std::vector<float> black(images.u.size(), 0);
    EXPECT_FALSE(seed_errors(CrossMeter(kSize, black, black), std::vector(2, black)).relative_mse);
}

}  // namespace
}  // namespace photond::seed_errors_test
