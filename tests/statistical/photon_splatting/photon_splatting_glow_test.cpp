// Beams are as wide as what casts them asks for, not as the scene is: a glass on a large floor has no glow.

#include <gtest/gtest.h>

#include "renderer/methods/photon_splatting/photon_splatting.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/glow_check.h"
#include "tests/support/path_render.h"

namespace photond::photon_splatting_glow_test {
namespace {

TEST(PhotonSplattingGlow, AGlassOnALargeFloorHasNone) {
    const Scene scene = make_builtin_scene("caustics/glass-on-floor");
    test::RenderSettingsOf<PhotonSplatting> settings;
    settings.passes = 2;
    test::expect_same_glow(test::glow([&](uint64_t seed) {
                               settings.seed = seed;
                               return test::render(scene, settings);
                           }),
                           test::traced_glow(scene));
}

// Radiance of the box with the glass sphere and the mirror, over the picture: within 0.3 % of path tracing, and what
// their noise is.
TEST(LongPhotonSplattingGlow, TheCausticBoxIsAsBrightAsPathTracingHasIt) {
    constexpr double kAllowed = 0.003, kMustNotice = 0.01, kFalseAlarm = 1e-6;
    constexpr size_t kFilms = 16;
    const Scene scene = make_builtin_scene("cornell-box-glass");
    test::RunningMean splatted, traced;
    for (uint64_t seed = 1; seed <= kFilms; ++seed) {
        test::RenderSettingsOf<PhotonSplatting> splats{.size = {128, 128}, .passes = 13, .seed = seed};
        test::RenderSettings paths{.size = {128, 128}, .passes = 256, .seed = 1000 + seed};
        splatted.add(test::mean_of(test::render(scene, splats).resolve_beauty()));
        traced.add(test::mean_of(test::render(scene, paths).resolve_beauty()));
    }
    const double t = test::two_sided_t(kFalseAlarm, double(kFilms) - 1);
    const double sigma = std::hypot(splatted.standard_error(), traced.standard_error()) / traced.mean();
    const double difference = splatted.mean() / traced.mean() - 1;
    std::printf("caustic box: %+.3f %%, standard error %.3f %%\n", 100 * difference, 100 * sigma);
    EXPECT_LE(std::abs(difference), kAllowed + t * sigma);
    EXPECT_LE(t * sigma, kMustNotice) << "too noisy to notice a defect";
}

}  // namespace
}  // namespace photond::photon_splatting_glow_test
