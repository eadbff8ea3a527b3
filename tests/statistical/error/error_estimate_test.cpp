// What a film says of its own error, against references of another seed.
//
// Of the values said to lie within 90 % confidence 85 to 95 % are to do so, pooled over an image's values that have a
// variance, averaged over runs of independent seeds; the reference's own standard error is added in quadrature.
// kPathTracing below lists all built-in scenes and which of them lie in that range after 256 passes. Those below have
// rare paths: a value whose variance comes from paths that few of its passes have found, or none, has a between-pass
// variance far below the true one, and no statistic of its passes can know. Such values are said to be better than they
// are, and estimated_relative_mse lies below relative_mse (its ratio is printed). More passes bring them nearer. After
// 64 passes furnace is above as well (0.99: Sobol' numbers are uneven at small powers of two there).

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/error/error_meter.h"
#include "renderer/error/estimate.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/scene.h"
#include "tests/support/path_render.h"
#include "tests/support/statistics.h"

namespace photond::error_estimate_test {
namespace {

constexpr Size2 kSize{32, 32};
constexpr uint64_t kReferenceSeed = 1'000'001;
constexpr double kLeastShare = 0.85, kMostShare = 0.95;
constexpr double kFalseAlarm = 1e-6;

/// A film's image and what is estimated of it.
struct Observed {
    std::vector<float> image, standard_error;
    ErrorEstimate estimate;
};

/// After each of `points` passes (rising); the estimator also sees all powers of two, as in a job.
template <class M>
std::vector<Observed> observe(const Scene& scene, const test::RenderSettingsOf<M>& settings,
                              const std::vector<uint32_t>& points) {
    MemoryBudget budget;
    Stats stats;
    const std::unique_ptr<Intersector> intersector = make_embree_intersector(scene, budget, stats);
    M method(settings.params);
    method.begin({scene, intersector.get(),
                  View{find_camera(scene, ""), settings.size, settings.filter, settings.layers}, settings.seed, budget},
                 stats);
    Film film(settings.size, settings.layers);
    ErrorEstimator estimator;
    std::vector<Observed> observed;
    for (uint32_t passes = 1; observed.size() < points.size(); ++passes) {
        method.run_pass(passes - 1, stats, CancelToken{});
        method.resolve(film);
        const bool wanted = passes == points[observed.size()];
        if (!wanted && (passes & (passes - 1)) != 0) continue;
        const std::vector<float> variance = film.pass_variance_beauty();
        Observed now{film.resolve_beauty(), variance, {}};
        const std::optional<ErrorEstimate> estimate = estimator.update(passes, now.image, variance);
        if (!wanted) continue;
        now.estimate = estimate.value();
        for (float& v : now.standard_error)
            v = static_cast<float>(now.estimate.standard_error_scale) * std::sqrt(v / static_cast<float>(passes));
        observed.push_back(std::move(now));
    }
    return observed;
}

/// Means over the runs of independent seeds.
struct Calibration {
    std::vector<double> shares;  // by run
    test::RunningMean scale, estimated, measured;

    double share() const { return test::mean_interval(shares, kFalseAlarm, 1).mean; }
    double error_ratio() const { return estimated.mean() / measured.mean(); }
};

struct Plan {
    std::vector<uint32_t> points;  // passes
    uint32_t reference_passes;
    size_t seeds;
};

/// One for each of the plan's points.
template <class M, class ReferenceMethod = M>
std::vector<Calibration> calibrate(std::string_view name, const Plan& plan, SamplerKind sampler = SamplerKind::Sobol) {
    const Scene scene = make_builtin_scene(name);
    test::RenderSettingsOf<ReferenceMethod> reference_settings;
    reference_settings.size = kSize;
    reference_settings.seed = kReferenceSeed;
    const Observed reference = observe(scene, reference_settings, {plan.reference_passes})[0];
    test::RenderSettingsOf<M> settings;
    settings.size = kSize;
    const ErrorMeter meter(kSize, reference.image);
    std::vector<Calibration> found(plan.points.size());
    settings.params.sampler = sampler;
    for (settings.seed = 1; settings.seed <= plan.seeds; ++settings.seed) {
        const std::vector<Observed> runs = observe(scene, settings, plan.points);
        for (size_t i = 0; i < runs.size(); ++i) {
            found[i].shares.push_back(share_within(runs[i].image, runs[i].standard_error, reference.image,
                                                   reference.standard_error, kConfidenceZ)
                                          .value());
            found[i].scale.add(runs[i].estimate.standard_error_scale);
            found[i].estimated.add(runs[i].estimate.estimated_relative_mse);
            found[i].measured.add(meter.pointwise(runs[i].image)[Metric::RelativeMse].value());
        }
    }
    for (size_t i = 0; i < found.size(); ++i)
        std::printf("%s %-20s %4u passes: share %.3f, scale %.3f, estimated / measured relative_mse %.3f (%.3g)\n",
                    M::kName, std::string(name).c_str(), plan.points[i], found[i].share(), found[i].scale.mean(),
                    found[i].error_ratio(), found[i].measured.mean());
    return found;
}

/// The share's mean over the runs, with the half-width that its own scatter gives at kFalseAlarm: a true mean inside of
/// the range fails by chance with less than that, one farther outside of it than 2 x `resolution` is noticed.
void expect_inside(const Calibration& found, double resolution = 0.015, size_t checks = 1) {
    const test::Interval share = test::mean_interval(found.shares, kFalseAlarm, checks);
    EXPECT_GE(share.mean + share.half_width, kLeastShare);
    EXPECT_LE(share.mean - share.half_width, kMostShare);
    EXPECT_LT(share.half_width, resolution);
}
enum class Expected : uint8_t { Below, Inside, Above };

/// By more than the runs' noise allows for. The error itself is said to be too small either way: rare paths.
void expect_outside(const Calibration& found, Expected side, size_t checks) {
    const test::Interval share = test::mean_interval(found.shares, kFalseAlarm, checks);
    if (side == Expected::Below) {
        EXPECT_LT(share.mean + share.half_width, kLeastShare);
    } else {
        EXPECT_GT(share.mean - share.half_width, kMostShare);
    }
    EXPECT_LT(found.error_ratio(), 1);
}

struct SceneRow {
    std::string_view name;
    Expected share;
};
constexpr SceneRow kPathTracing[] = {
    {"cornell-box", Expected::Inside},
    {"cornell-box-spot", Expected::Inside},
    {"cornell-box-glass", Expected::Below},  // 0.82: caustics of the lamp, which only diffuse bounces find
    {"cornell-box-glossy", Expected::Inside},
    {"furnace", Expected::Inside},
    // 0.96: most of the image is plain and far better than the caustic, which the scale is of.
    {"caustic-ring", Expected::Above},
    {"keyhole", Expected::Below},    // 0.83: few paths pass the keyhole
    {"interior", Expected::Inside},  // 0.858, +- 0.011, at the edge: rare paths off glass and metal, small windows
};

TEST(ErrorEstimate, CornellBoxesAfter64Passes) {
    for (const std::string_view name : {"cornell-box", "cornell-box-spot"}) {
        SCOPED_TRACE(name);
        const Calibration found = calibrate<PathTracing>(name, {{64}, 2048, 32})[0];
        expect_inside(found);
        EXPECT_GT(found.error_ratio(), 0.6);
        EXPECT_LT(found.error_ratio(), 1.3);
    }
}

TEST(ErrorEstimateLong, AllScenesAfter256Passes) {
    ASSERT_EQ(std::size(kPathTracing), builtin_scene_names().size());
    for (const SceneRow& row : kPathTracing) {
        SCOPED_TRACE(row.name);
        const Calibration found = calibrate<PathTracing>(row.name, {{64, 256}, 2048, 32})[1];
        if (row.share == Expected::Inside) {
            // Furnace's few, equal paths make its runs differ more than those of other scenes.
            expect_inside(found, row.name == "furnace" ? 0.03 : 0.015, std::size(kPathTracing));
        } else {
            expect_outside(found, row.share, std::size(kPathTracing));
        }
    }
}

TEST(ErrorEstimate, IndependentPassesNeedNoScale) {
    const Calibration found = calibrate<PathTracing>("cornell-box", {{64}, 1024, 32}, SamplerKind::Random)[0];
    // A slope that noise makes negative is believed, a positive one is not: f is a little low.
    EXPECT_NEAR(found.scale.mean(), 1, 0.05);
}

/// Independent Gaussian passes of known mean and variance.
TEST(ErrorEstimate, ScaleOfGaussianNoiseIsOneAtAnyPasses) {
    constexpr size_t kValues = 30000;
    std::vector<double> sum(kValues, 0), squares(kValues, 0);
    const std::vector<float> mean(kValues, 2.0f), sigma(kValues, 0.5f);
    ErrorEstimator estimator;
    for (uint32_t n = 1; n <= 200; ++n) {
        const std::vector<float> pass = with_own_noise(mean, sigma, n);
        for (size_t i = 0; i < kValues; ++i) sum[i] += pass[i], squares[i] += double{pass[i]} * pass[i];
        if ((n & (n - 1)) != 0 && n % 50 != 0) continue;
        std::vector<float> image(kValues), variance(n > 1 ? kValues : 0);
        for (size_t i = 0; i < kValues; ++i) {
            image[i] = static_cast<float>(sum[i] / n);
            if (n > 1) variance[i] = static_cast<float>((squares[i] - sum[i] * sum[i] / n) / (n - 1));
        }
        const std::optional<ErrorEstimate> estimate = estimator.update(n, image, variance);
        ASSERT_EQ(estimate.has_value(), n >= 2);
        if (n < 2) continue;
        // Scale: standard deviation of a level's ratio is sqrt(2 / values) = 0.8 %; with the slope's at most twice
        // that.
        EXPECT_NEAR(estimate->standard_error_scale, 1, 0.06) << n;
        if (n >= 8) {
            EXPECT_NEAR(estimate->estimated_relative_mse * n, 0.25 / (4 + 0.04), 0.12 * 0.25 / 4) << n;
        }
    }
}

/// A value that one pass alone makes: its halves differ by what independent passes would make them differ.
TEST(ErrorEstimate, LoneEventsAreIndependent) {
    constexpr uint32_t n = 16;
    constexpr float kEvent = 64;
    std::vector<float> half(300, 1), image = half, variance(300, 0);
    for (size_t i = 0; i < 300; i += 3) {
        if (i % 2 == 1) half[i] += kEvent / (n / 2);  // in the first half; else in the second
        image[i] += kEvent / n;
        variance[i] = kEvent * kEvent / n;
    }
    ErrorEstimator estimator;
    estimator.update(n / 2, half, variance);
    EXPECT_NEAR(estimator.update(n, image, variance)->standard_error_scale, 1, 1e-6);
}

TEST(ErrorEstimate, PassesThatAreAlikeHaveNoError) {
    const std::vector<float> image(30, 1), variance(30, 0), black(30, 0);
    ErrorEstimator estimator, dark;
    for (const uint32_t n : {1, 2, 4, 8}) {
        const std::optional<ErrorEstimate> estimate = estimator.update(n, image, variance);
        EXPECT_FALSE(dark.update(n, black, variance).has_value());
        if (n == 1) continue;
        EXPECT_EQ(estimate->estimated_relative_mse, 0);
        EXPECT_EQ(estimate->standard_error_scale, 1);
    }
}

TEST(ErrorEstimate, ValuesWithoutKnownVarianceAreLeftOut) {
    const float inf = std::numeric_limits<float>::infinity();
    const std::vector<float> image{2, 2, inf}, variance{1, inf, 1};
    // m = 2, weight 1 / (4 - 1 + 0.04).
    EXPECT_NEAR(expected_relative_mse(image, variance).value(), 1 / 3.04, 1e-9);
    EXPECT_FALSE(expected_relative_mse(image, std::vector<float>(3, inf)).has_value());
    const std::vector<float> reference{0, 0, 0}, one{1, 1, 1}, none(3, 0);
    EXPECT_EQ(share_within(std::vector<float>{0.5f, 1.5f, 5}, std::vector<float>{1, 1, inf}, reference, {}, 1), 0.5);
    EXPECT_EQ(share_within(std::vector<float>{0.5f, 1.3f, 5}, one, reference, one, 1), 2.0 / 3);
    EXPECT_FALSE(share_within(one, none, reference, one, 1).has_value());
}

TEST(ErrorEstimate, OwnNoiseHasItsExpectedRelativeMse) {
    constexpr size_t kValues = 30000;
    const float inf = std::numeric_limits<float>::infinity();
    std::vector<float> reference(kValues), error(kValues);
    for (size_t i = 0; i < kValues; ++i) {
        reference[i] = 0.1f + 0.01f * static_cast<float>(i % 300);
        error[i] = i % 100 == 0 ? (i % 200 ? inf : std::nanf("")) : 0.001f * static_cast<float>(1 + i % 70);
    }
    const std::vector<float> noisy = with_own_noise(reference, error, 7);
    EXPECT_EQ(noisy, with_own_noise(reference, error, 7));
    EXPECT_NE(noisy, with_own_noise(reference, error, 8));
    const double m = test::mean_of(reference);
    double expected = 0, variance = 0, measured = 0;
    for (size_t i = 0; i < kValues; ++i) {
        const double difference = double{noisy[i]} - double{reference[i]};
        if (!std::isfinite(error[i])) {
            EXPECT_EQ(noisy[i], reference[i]);  // no noise is known of
            continue;
        }
        const double weight = 1 / (double{reference[i]} * reference[i] + 0.01 * m * m) / kValues;
        const double e2 = double{error[i]} * error[i];
        expected += weight * e2, variance += 2 * weight * weight * e2 * e2;  // Var z^2 = 2
        measured += weight * difference * difference;
    }
    EXPECT_NEAR(measured, expected, test::two_sided_z(kFalseAlarm) * std::sqrt(variance));
}

}  // namespace
}  // namespace photond::error_estimate_test
