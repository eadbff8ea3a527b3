// Stratified splats that connect, against an independent renderer's image of one bounce in the diffuse Cornell box
// (tests/data/reference): which photon stands for its cell decides whether light is lost. The ceiling is judged first,
// for it is where the thesis loses intensity (its Figure 15).

#include <gtest/gtest.h>

#include "renderer/methods/photon_splatting/photon_splatting.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/reference_bias.h"

namespace photond::photon_splatting_stratified_test {
namespace {

using test::Mask;
using Settings = test::RenderSettingsOf<PhotonSplatting>;

constexpr double kFalseAlarm = 1e-6;  // of all checks of this file together, short and long
constexpr size_t kChecks = 3 * (2 * 3) + 2 * 3;
constexpr uint32_t kSide = 64;

struct Plan {
    uint32_t films, passes;
    double must_notice;  // relative, on the ceiling
    bool allow_noise;
};

/// On the whole picture and on the ceiling, by channel.
std::vector<std::array<test::RelativeBias, 3>> biases_of(Representative representative, const Plan& plan) {
    const Scene scene = make_builtin_scene("cornell-box");
    const std::vector<float> positions = test::positions_seen(scene, test::kReferenceSize);
    Mask ceiling(test::kReferenceSize.pixels());
    for (size_t i = 0; i < ceiling.size(); ++i) ceiling[i] = positions[3 * i + 1] > scene.bounds.max.y - 1e-3f;
    ceiling = test::reduced_mask(ceiling, kSide);
    EXPECT_GT(test::count_of(ceiling), 200u);

    Settings settings;
    settings.size = {kSide, kSide};
    settings.passes = plan.passes;
    settings.params.photons = 20'000;
    settings.params.bounces = 1;  // as the reference has
    settings.params.splat_size_m = 0.5f;
    settings.params.stratify = true;
    settings.params.grid_cells = 32;  // a third of the cells that hold photons hold more than two
    settings.params.minimum_photons = 1;
    settings.params.representative = representative;
    const std::vector<float> expected = test::reduced(test::reference_image("indirect_one_bounce_256.exr"), kSide);
    return test::relative_biases(scene, settings, plan.films, {expected, expected}, {{}, ceiling},
                                 test::share_of_false_alarm(kFalseAlarm, kChecks));
}

void print(const char* representative, const std::vector<std::array<test::RelativeBias, 3>>& biases) {
    for (size_t r = 0; r < 2; ++r) {
        std::printf("%s, %s:", representative, r == 0 ? "whole picture" : "ceiling");
        for (const test::RelativeBias& bias : biases[r])
            std::printf("  %+.2f %% (standard error %.2f %%)", 100 * bias.value, 100 * bias.standard_error);
        std::printf("\n");
    }
}

void expect_no_loss(Representative representative, const char* name, const Plan& plan) {
    constexpr double kAllowed = 1e-2;
    const auto biases = biases_of(representative, plan);
    print(name, biases);
    for (const auto& region : biases)
        for (const test::RelativeBias& bias : region) {
            EXPECT_LE(std::abs(bias.value), kAllowed + (plan.allow_noise ? bias.noise : 0)) << name;
            EXPECT_LE(bias.noise, plan.must_notice) << name << ": too noisy to notice a defect";
        }
}

TEST(PhotonSplattingStratified, ByPowerNoLightIsLost) {
    expect_no_loss(Representative::ByPower, "by_power", {24, 4, 0.06, true});
}
TEST(PhotonSplattingStratifiedLong, NoLightIsLost) {
    expect_no_loss(Representative::ByPower, "by_power", {48, 12, 0.015, false});
    expect_no_loss(Representative::Random, "random", {48, 12, 0.015, false});
}

/// What the thesis' two make of the light is printed. The second prefers the directions of most photons, here those
/// from the floor up: a bias that must be seen, or these tests see nothing.
void print_biased(const Plan& plan) {
    print("closest_to_mean", biases_of(Representative::ClosestToMean, plan));
    const auto dominant = biases_of(Representative::DominantDirection, plan);
    print("dominant_direction", dominant);
    for (const test::RelativeBias& bias : dominant[1]) EXPECT_GT(bias.value, bias.noise);
}

TEST(PhotonSplattingStratified, TheThesisRepresentativesAreBiased) { print_biased({12, 2, 0, true}); }
TEST(PhotonSplattingStratifiedLong, TheThesisRepresentativesAreBiased) { print_biased({48, 12, 0, true}); }

}  // namespace
}  // namespace photond::photon_splatting_stratified_test
