// How fast path tracing converges: its relative_mse falls as 1/passes with random numbers, and no slower with
// low-discrepancy ones.
//
// A run of 1,024 passes gives 1,024/n images of n consecutive passes; the level n is the mean of their relative_mse, so
// that all levels have seen the same paths. The slope of log relative_mse over log passes is fitted to the levels 16,
// 32 ... 1,024 by least squares, once for each seed; the mean over the seeds is judged, with Student's t over them as
// its noise. Expected of random numbers: -1 exactly.
// - The reference is of another seed, low-discrepancy and of at least 16 times as many passes. Even with the error of
//   as many independent passes, 1/16 of the last level's, it would make the slope 0.013 too flat (1/32 of the level
//   before, and so on); it has less than half of that error.
// - The mean of a logarithm is lower than the logarithm of the mean by half the relative variance of relative_mse: in
//   the last level, the worst, about 0.01 / 2 a seed, which is 0.001 of slope.

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/error/error_meter.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/scene.h"
#include "tests/support/convergence.h"
#include "tests/support/path_render.h"

namespace photond::convergence_test {
namespace {

constexpr uint32_t kFirst = 16, kLast = 1024;
constexpr double kFalseAlarm = 1e-6;
constexpr size_t kChecks = 2 * 2;  // both samplers, short and long
constexpr double kNarrow = 0.05;   // of the slope, to either side: what is known so well is not measured further

struct Plan {
    Size2 size;
    uint32_t reference_passes;
    size_t seeds;
};

test::RenderSettings settings_of(const Plan& plan, SamplerKind sampler, uint64_t seed) {
    test::RenderSettings settings;
    settings.size = plan.size;
    settings.seed = seed;
    settings.passes = kLast;
    settings.params.sampler = sampler;
    return settings;
}

/// Slope of log relative_mse over log passes in one run.
double slope_of(const Scene& scene, const test::RenderSettings& settings, const ErrorMeter& meter) {
    return test::slope_over_doublings(test::errors_of_doubled_passes(scene, settings, kFirst, [&](const Film& film) {
        return meter.pointwise(film.resolve_beauty())[Metric::RelativeMse].value();
    }));
}

std::vector<float> reference_of(const Scene& scene, const Plan& plan, uint64_t seed) {
    test::RenderSettings settings = settings_of(plan, SamplerKind::Sobol, seed);
    settings.passes = plan.reference_passes;
    return test::render(scene, settings).resolve_beauty();
}

void expect_convergence(const Plan& plan) {
    const Scene scene = make_builtin_scene("cornell-box");
    const ErrorMeter meter(plan.size, reference_of(scene, plan, 1'000'001));
    const auto slope = [&](SamplerKind sampler) {
        const test::Interval found = test::interval_when_narrow(
            kNarrow, plan.seeds, kFalseAlarm, kChecks,
            [&](uint64_t seed) { return slope_of(scene, settings_of(plan, sampler, seed), meter); });
        std::printf("%s: slope %.4f, +- %.4f at a false-alarm rate of %g\n",
                    sampler == SamplerKind::Random ? "random" : "sobol", found.mean, found.half_width, kFalseAlarm);
        return found;
    };
    const test::Interval random = slope(SamplerKind::Random), sobol = slope(SamplerKind::Sobol);
    EXPECT_LE(random.half_width, kNarrow) << "too noisy to judge";
    EXPECT_NEAR(random.mean, -1, 0.05);
    EXPECT_LE(sobol.mean + sobol.half_width, -1) << "less steep than independent numbers";
}

TEST(Convergence, PathTracingFallsAsOneOverPasses) { expect_convergence({{16, 16}, 16384, 32}); }
TEST(ConvergenceLong, PathTracingFallsAsOneOverPasses) { expect_convergence({{48, 48}, 65536, 48}); }

}  // namespace
}  // namespace photond::convergence_test
