// Progressive photon mapping's images against path tracing's: the box with the glass sphere and the mirror block.

#include <gtest/gtest.h>

#include "renderer/methods/probabilistic_progressive_photon_mapping/probabilistic_progressive_photon_mapping.h"
#include "renderer/methods/progressive_photon_mapping/progressive_photon_mapping.h"
#include "renderer/methods/stochastic_progressive_photon_mapping/stochastic_progressive_photon_mapping.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/path_render.h"
#include "tests/support/statistics.h"

namespace photond::progressive_images_test {
namespace {

constexpr double kFalseAlarm = 1e-6;
constexpr size_t kChecks = 10;

/// Of the indirect light, film by film.
template <class M>
test::RunningMean means_of(const Scene& scene, test::RenderSettingsOf<M> settings, uint64_t films) {
    settings.size = {32, 32};
    test::RunningMean mean;
    for (settings.seed = 1; settings.seed <= films; ++settings.seed)
        mean.add(test::mean_of(test::render(scene, settings).resolve(Layer::Indirect)));
    return mean;
}

template <class M>
std::string name_of(RadiusRule rule) {
    return std::string(M::kName) + ", rule " + std::to_string(int(rule));
}

/// `mean` is `truth` within `allowed` and noise, as shares of it; what `must_notice` of it off would be noticed.
/// `sigma`: the standard error of their difference, which has that many degrees of freedom.
void expect_mean_of(const test::RunningMean& mean, double truth, double sigma, double degrees, const std::string& name,
                    double allowed, double must_notice) {
    const double difference = mean.mean() / truth - 1;
    const double noise = test::two_sided_t(test::share_of_false_alarm(kFalseAlarm, kChecks), degrees) * sigma / truth;
    std::printf("%-50s %+.3f %%, within %.3f %%, standard error %.3f %% (photons %.3f %%)\n", name.c_str(),
                100 * difference, 100 * noise, 100 * sigma / truth, 100 * mean.standard_error() / truth);
    EXPECT_LE(std::abs(difference), allowed + noise) << name;
    EXPECT_LE(noise, must_notice) << name << ": too noisy to notice a defect";
}

template <class M>
void expect_mean(const Scene& scene, const test::RunningMean& truth, RadiusRule rule, double allowed,
                 double must_notice) {
    test::RenderSettingsOf<M> settings;
    settings.passes = 5;
    settings.params.photons = 10'000;
    settings.params.radius_rule = rule;
    const test::RunningMean mean = means_of(scene, settings, 12);
    expect_mean_of(mean, truth.mean(), std::hypot(mean.standard_error(), truth.standard_error()),
                   test::degrees_of_difference(mean, truth), name_of<M>(rule), allowed, must_notice);
}

TEST(ProgressiveImages, MeansAreThoseOfPathTracing) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    test::RenderSettings paths;
    paths.passes = 45;
    const test::RunningMean truth = means_of(scene, paths, 32);
    expect_mean<ProbabilisticProgressivePhotonMapping>(scene, truth, RadiusRule::Trained, 0.01, 0.05);
    expect_mean<ProbabilisticProgressivePhotonMapping>(scene, truth, RadiusRule::Global, 0.01, 0.05);
    expect_mean<StochasticProgressivePhotonMapping>(scene, truth, RadiusRule::Local, 0.01, 0.05);
    expect_mean<StochasticProgressivePhotonMapping>(scene, truth, RadiusRule::Tested, 0.01, 0.05);
    expect_mean<ProgressivePhotonMapping>(scene, truth, RadiusRule::Local, 0.01, 0.05);
}

// Of the radiance 1 / (1 - 0.5) that is everywhere a quarter has scattered more than once. Discs are clipped where
// walls meet, so that none of it is lost.
template <class M>
void expect_furnace(const Scene& scene, RadiusRule rule) {
    test::RenderSettingsOf<M> settings;
    settings.passes = 2;
    settings.params.photons = 10'000;
    settings.params.radius_rule = rule;
    const test::RunningMean mean = means_of(scene, settings, 24);
    expect_mean_of(mean, 0.5, mean.standard_error(), double(mean.count()) - 1, name_of<M>(rule), 0.002, 0.03);
}

TEST(ProgressiveImages, AFurnaceIsEven) {
    const Scene scene = make_builtin_scene("hard-case/furnace-albedo-50");
    expect_furnace<ProbabilisticProgressivePhotonMapping>(scene, RadiusRule::Trained);
    expect_furnace<ProbabilisticProgressivePhotonMapping>(scene, RadiusRule::Global);
    expect_furnace<StochasticProgressivePhotonMapping>(scene, RadiusRule::Local);
    expect_furnace<StochasticProgressivePhotonMapping>(scene, RadiusRule::Tested);
    expect_furnace<ProgressivePhotonMapping>(scene, RadiusRule::Local);
}

}  // namespace
}  // namespace photond::progressive_images_test
