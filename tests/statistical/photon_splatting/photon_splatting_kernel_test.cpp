// Splats with a bias, against an independent renderer's image of one bounce in the diffuse Cornell box
// (tests/data/reference): beams that shrink lose theirs at the rate that theory gives, the thesis' normalised splats
// keep it for ever.

#include <gtest/gtest.h>

#include "renderer/error/error_meter.h"
#include "renderer/methods/photon_splatting/photon_splatting.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/reference_images.h"
#include "tests/support/render.h"
#include "tests/support/statistics.h"

namespace photond::photon_splatting_kernel_test {
namespace {

using test::Mask;
using Settings = test::RenderSettingsOf<PhotonSplatting>;

constexpr double kFalseAlarm = 1e-6;     // of all checks of this file together
constexpr size_t kChecks = 2 * (2 + 2);  // slopes and floors, short and long
constexpr float kSplatSize = 0.5f;       // [m]: a room of 5.5 m has pixels farther than the radius from any edge

std::vector<float> one_bounce(uint32_t side) {
    return test::reduced(test::reference_image("indirect_one_bounce_256.exr"), side);
}

struct Plan {
    uint32_t side, photons, first, last;  // photons a pass; passes
    uint32_t shadow_resolution;
    size_t seeds;
    double must_notice;  // in the slope
    bool asymptotic;     // many passes: slopes are judged as they stand, and those at edges too
};

/// Pixels whose points lie farther than the first pass's radius from any edge, and the others that see a surface.
struct Regions {
    Mask far, rest;
    Regions(const Scene& scene, uint32_t side) {
        far = test::reduced_mask(test::far_from_edges(scene, test::kReferenceSize, kSplatSize / 2), side);
        const std::vector<float> positions = test::positions_seen(scene, {side, side});
        rest.resize(far.size());
        for (size_t i = 0; i < rest.size(); ++i)
            rest[i] = !far[i] && (positions[3 * i] != 0 || positions[3 * i + 1] != 0 || positions[3 * i + 2] != 0);
    }
};

/// Mean squared errors after first, 2 first ... last passes of one run, less the reference's own noise.
struct Errors {
    std::vector<double> far, rest;
};

Errors errors_of_run(const Scene& scene, const Plan& plan, const Regions& regions, const std::vector<float>& expected,
                     uint64_t seed) {
    Settings settings;
    settings.size = {plan.side, plan.side};
    settings.passes = plan.last;
    settings.seed = seed;
    settings.params.photons = plan.photons;
    settings.params.bounces = 1;  // as the reference has
    settings.params.estimator = SplatEstimator::Kernel;
    settings.params.splat_size_m = kSplatSize;
    settings.params.shadow_resolution = plan.shadow_resolution;
    const double noise = test::reference_noise_of_mean(Mask(1, 1), settings.size.pixels());
    Film film(settings.size, settings.layers);
    Errors errors;
    test::run_passes(scene, settings, [&](PhotonSplatting& method, uint32_t pass) {
        method.resolve(film);
        if (pass + 1 < plan.first << errors.far.size()) return;
        const std::vector<float> image = film.resolve(Layer::Indirect);
        errors.far.push_back(test::masked_mse(image, expected, regions.far) - noise * noise);
        errors.rest.push_back(test::masked_mse(image, expected, regions.rest) - noise * noise);
    });
    return errors;
}

/// With alpha 2/3 the area of a beam falls as N^-1/3: variance and squared blur both fall as N^-2/3. Within a radius of
/// an edge, where up to half the light is lost, the loss stays and the strip becomes narrower: in pixels wider than
/// that N^-1/6 in the RMSE, N^-1/3 in the MSE (derivations.md, "Splats with a kernel"). Beams that do not shrink give
/// another slope: -1 while their noise prevails, 0 when their blur does.
void expect_slopes_of_theory(const Plan& plan) {
    const Scene scene = make_builtin_scene("cornell-box");
    const Regions regions(scene, plan.side);
    const std::vector<float> expected = one_bounce(plan.side);
    EXPECT_GT(test::count_of(regions.far), regions.far.size() / 4);
    EXPECT_GT(test::count_of(regions.rest), regions.rest.size() / 4);
    std::vector<double> far, rest;
    for (size_t seed = 1; seed <= plan.seeds; ++seed) {
        const Errors errors = errors_of_run(scene, plan, regions, expected, seed);
        far.push_back(test::slope_over_doublings(errors.far));
        rest.push_back(test::slope_over_doublings(errors.rest));
    }
    const auto judge = [&](const char* where, const std::vector<double>& slopes, double least, double most) {
        const test::Interval slope = test::mean_interval(slopes, kFalseAlarm, kChecks);
        std::printf("%s: MSE slope %.3f +- %.3f from %u to %u passes of %u photons\n", where, slope.mean,
                    slope.half_width, plan.first, plan.last, plan.photons);
        const double noise = plan.asymptotic ? 0 : slope.half_width;
        EXPECT_LE(slope.mean, most + noise) << where;
        EXPECT_GE(slope.mean, least - noise) << where;
        EXPECT_LE(slope.half_width, plan.must_notice) << where << ": too noisy to notice a defect";
    };
    judge("farther than the first radius from edges", far, -0.75, -0.6);
    // Of few photons the noise, which falls faster, prevails at edges too.
    judge("the rest", rest, plan.asymptotic ? -0.45 : -0.75, -0.2);
}

TEST(PhotonSplattingKernel, BeamsThatShrinkConvergeAsTheoryGives) {
    expect_slopes_of_theory({32, 5000, 4, 64, 4, 12, 0.2, false});
}
TEST(PhotonSplattingKernelLong, BeamsThatShrinkConvergeAsTheoryGives) {
    expect_slopes_of_theory({64, 20'000, 16, 1024, 8, 12, 0.1, true});
}

struct FloorPlan {
    uint32_t photons, passes;  // photons a pass; 16 times as many passes are compared with so many
    size_t seeds;
};

/// Errors of the indirect layer, as they are and after the exposure that makes them least; means over seeds.
struct NormalisedErrors {
    test::RunningMean raw, fitted, exposure;
};

NormalisedErrors normalised_errors(const Scene& scene, const ErrorMeter& meter, const FloorPlan& plan,
                                   uint32_t passes) {
    Settings settings;
    settings.size = meter.size();
    settings.passes = passes;
    settings.params.photons = plan.photons;
    settings.params.bounces = 1;  // as the reference has
    settings.params.weighting = SplatWeighting::Normalised;
    settings.params.splat_size_m = kSplatSize;
    settings.params.shadow_resolution = 4;
    NormalisedErrors errors;
    for (settings.seed = 1; settings.seed <= plan.seeds; ++settings.seed) {
        const PointwiseErrors found = meter.pointwise(test::render(scene, settings).resolve(Layer::Indirect));
        errors.raw.add(found[Metric::RelativeMse].value());
        errors.fitted.add(found[Metric::FittedRelativeMse].value());
        errors.exposure.add(found.relative_least_squares_exposure.value());
    }
    std::printf(
        "normalised, %u passes of %u photons: relative MSE %.4f (standard error %.4f), %.4f (%.4f) after an "
        "exposure of %.3f\n",
        passes, plan.photons, errors.raw.mean(), errors.raw.standard_error(), errors.fitted.mean(),
        errors.fitted.standard_error(), errors.exposure.mean());
    return errors;
}

/// The thesis' weighting discards the density of photons. An error that vanished as that of beams does would fall to
/// 16^(-2/3) = 0.16 with 16 times the passes.
void expect_floor(const FloorPlan& plan) {
    const Scene scene = make_builtin_scene("cornell-box");
    const ErrorMeter meter({32, 32}, one_bounce(32));
    const NormalisedErrors few = normalised_errors(scene, meter, plan, plan.passes);
    const NormalisedErrors many = normalised_errors(scene, meter, plan, 16 * plan.passes);
    const double t = test::two_sided_t(test::share_of_false_alarm(kFalseAlarm, kChecks), double(plan.seeds) - 1);
    EXPECT_GT(many.raw.mean() - t * many.raw.standard_error(), few.raw.mean() / 3);
    EXPECT_GT(many.fitted.mean() - t * many.fitted.standard_error(), few.fitted.mean() / 3);
}

TEST(PhotonSplattingKernel, NormalisedSplatsKeepAFloor) { expect_floor({5000, 6, 6}); }
TEST(PhotonSplattingKernelLong, NormalisedSplatsKeepAFloor) { expect_floor({20'000, 16, 8}); }

}  // namespace
}  // namespace photond::photon_splatting_kernel_test
