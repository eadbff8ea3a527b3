// Progressive photon mapping's images against path tracing's: the box with the glass sphere and the mirror block.

#include <gtest/gtest.h>

#include "renderer/methods/probabilistic_progressive_photon_mapping/probabilistic_progressive_photon_mapping.h"
#include "renderer/methods/progressive_photon_mapping/progressive_photon_mapping.h"
#include "renderer/methods/stochastic_progressive_photon_mapping/stochastic_progressive_photon_mapping.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/render.h"
#include "tests/support/statistics.h"

namespace photond::progressive_images_test {
namespace {

constexpr uint64_t kFilms = 12;
constexpr double kFalseAlarm = 1e-6;
constexpr size_t kChecks = 6;

template <class M>
test::RunningMean means_of(const Scene& scene, test::RenderSettingsOf<M> settings) {
    settings.size = {32, 32};
    test::RunningMean mean;
    for (settings.seed = 1; settings.seed <= kFilms; ++settings.seed)
        mean.add(test::mean_of(test::render(scene, settings).resolve(Layer::Indirect)));
    return mean;
}

/// The indirect light of the picture is path tracing's within `allowed` and noise; what `must_notice` of it off would
/// be noticed.
template <class M>
void expect_mean(const Scene& scene, const test::RunningMean& truth, RadiusRule rule, double allowed,
                 double must_notice) {
    test::RenderSettingsOf<M> settings;
    settings.passes = 8;
    settings.params.photons = 10'000;
    settings.params.radius_rule = rule;
    const test::RunningMean mean = means_of(scene, settings);
    const double difference = mean.mean() / truth.mean() - 1;
    const double sigma = std::hypot(mean.standard_error(), truth.standard_error()) / truth.mean();
    const double t = test::two_sided_t(test::share_of_false_alarm(kFalseAlarm, kChecks), double(kFilms) - 1);
    std::printf("%-42s rule %d: %+.3f %%, standard error %.3f %% (photons %.3f %%)\n", M::kName, int(rule),
                100 * difference, 100 * sigma, 100 * mean.standard_error() / truth.mean());
    EXPECT_LE(std::abs(difference), allowed + t * sigma);
    EXPECT_LE(t * sigma, must_notice) << "too noisy to notice a defect";
}

TEST(ProgressiveImages, MeansAreThoseOfPathTracing) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    test::RenderSettings paths;
    paths.passes = 400;
    const test::RunningMean truth = means_of(scene, paths);
    expect_mean<ProbabilisticProgressivePhotonMapping>(scene, truth, RadiusRule::Trained, 0.01, 0.05);
    expect_mean<ProbabilisticProgressivePhotonMapping>(scene, truth, RadiusRule::Global, 0.01, 0.05);
    expect_mean<StochasticProgressivePhotonMapping>(scene, truth, RadiusRule::Local, 0.01, 0.05);
    expect_mean<StochasticProgressivePhotonMapping>(scene, truth, RadiusRule::Tested, 0.01, 0.05);
    expect_mean<ProgressivePhotonMapping>(scene, truth, RadiusRule::Local, 0.01, 0.05);
}

}  // namespace
}  // namespace photond::progressive_images_test
