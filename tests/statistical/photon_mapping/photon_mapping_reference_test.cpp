// Photon mapping against images of the diffuse Cornell box made by an independent renderer (tests/data/reference).
//
// What is judged is the relative bias of a mean over many pixels. Photons are shared by all pixels of a pass, so its
// noise is that of the passes' means (Student's t over them), not of the pixels, with the reference's beside it. The
// long runs are held to the bias asked for as it stands; the short ones allow their own noise beside it. Both check
// that their noise is small enough to notice a defect.

#include <gtest/gtest.h>

#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/reference_bias.h"

namespace photond::photon_mapping_reference_test {
namespace {

constexpr Size2 kSize = test::kReferenceSize;
constexpr double kFalseAlarm = 1e-6;
constexpr size_t kChecks = 3 * 3 * 2;  // three channels of three comparisons, short and long

using test::Expected;
using test::Mask;
using Settings = test::RenderSettingsOf<PhotonMapping>;

struct Run {
    uint32_t groups, passes;  // films, and passes of each: the spread of the films' means is the noise
    double must_notice;       // relative
    bool allow_noise;         // beside the bias allowed
};

/// Checks the indirect layer's bias by channel; direct light is light sampling's, tested with path tracing.
void expect_bias_within(double allowed, const Run& run, const Scene& scene, Settings settings, const Expected& expected,
                        const Mask& mask = {}) {
    settings.passes = run.passes;
    const double share = test::share_of_false_alarm(kFalseAlarm, kChecks);
    const auto biases = test::relative_biases(scene, settings, run.groups, expected, {mask}, share).front();
    for (size_t c = 0; c < 3; ++c) {
        std::printf("channel %zu: relative bias %+.4f %%, standard error %.4f %%\n", c, 100 * biases[c].value,
                    100 * biases[c].standard_error);
        EXPECT_LE(std::abs(biases[c].value), allowed + (run.allow_noise ? biases[c].noise : 0)) << "channel " << c;
        EXPECT_LE(biases[c].noise, run.must_notice) << "too noisy to notice a defect";
    }
}

/// Emitted, direct and indirect light of the reference, and its indirect light alone.
Expected all_bounces() {
    Expected expected{test::reference_image("reference_256.exr"), test::reference_image("reference_256.exr")};
    const std::vector<float> direct = test::reference_image("direct_only_256.exr");
    for (size_t i = 0; i < direct.size(); ++i) expected.indirect[i] -= direct[i];
    return expected;
}

void final_gathering(std::optional<uint32_t> bounces, uint32_t gather_rays, const Run& run) {
    Settings settings;
    settings.size = kSize;
    settings.params.gather_rays = gather_rays;
    settings.params.indirect_bounces = bounces;
    const std::vector<float> one_bounce = test::reference_image("indirect_one_bounce_256.exr");
    expect_bias_within(3e-3, run, make_builtin_scene("cornell-box"), settings,
                       bounces ? Expected{one_bounce, one_bounce} : all_bounces());
}

/// Fixed radius of 0.05 m, 200,000 photons a pass. The bias is relative to the indirect light itself.
void direct_visualisation(const Run& run) {
    constexpr float kRadius = 0.05f;
    const Scene scene = make_builtin_scene("cornell-box");
    Settings settings;
    settings.size = kSize;
    settings.params.gather = Gather::Direct;
    settings.params.search = PhotonSearch::Kind::Radius;
    settings.params.radius_m = kRadius;

    const Mask mask = test::far_from_edges(scene, kSize, kRadius);
    EXPECT_GT(test::count_of(mask), 30000u);
    Expected expected = all_bounces();
    expected.relative_to = expected.indirect;
    expect_bias_within(1e-2, run, scene, settings, expected, mask);
}

constexpr Run kShort{12, 1, 0.03, true}, kLong{16, 2, 0.005, false}, kLongDirect{16, 4, 0.01, false};

TEST(PhotonMappingReference, FinalGatheringOfOneBounce) { final_gathering(1, 8, kShort); }
TEST(PhotonMappingReferenceLong, FinalGatheringOfOneBounce) { final_gathering(1, 64, kLong); }

TEST(PhotonMappingReference, FinalGatheringOfAllBounces) { final_gathering({}, 4, kShort); }
TEST(PhotonMappingReferenceLong, FinalGatheringOfAllBounces) { final_gathering({}, 64, kLong); }

TEST(PhotonMappingReference, DirectVisualisationFarFromEdges) { direct_visualisation(kShort); }
TEST(PhotonMappingReferenceLong, DirectVisualisationFarFromEdges) { direct_visualisation(kLongDirect); }

}  // namespace
}  // namespace photond::photon_mapping_reference_test
