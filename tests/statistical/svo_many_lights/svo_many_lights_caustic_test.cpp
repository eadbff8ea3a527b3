// Many lights' caustics, which are photons: light of any number of bounces in the box with the glass sphere and the
// mirror block, against path tracing, in the whole picture and where caustics fall; and of a point light, which no path
// from the eye meets behind the glass, against photon mapping.
//
// Photons only smear light within their radius, and lose what lies beyond an edge: a hundredth is allowed for that.

#include <gtest/gtest.h>

#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/methods/svo_many_lights/svo_many_lights.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/path_render.h"
#include "tests/support/statistics.h"

namespace photond::svo_many_lights_caustic_test {
namespace {

constexpr uint32_t kSide = 48;
constexpr double kFalseAlarm = 1e-6, kAllowed = 0.01;

/// Rows and columns of the picture, half open.
struct Part {
    const char* name;
    uint32_t top, bottom, left, right;
};
constexpr std::array kParts{Part{"whole picture", 0, kSide, 0, kSide}, Part{"floor about the sphere", 41, 48, 19, 46},
                            Part{"ceiling above the block", 0, 14, 2, 29}};
constexpr size_t kChecks = 2 * kParts.size();  // short and long; the point light's has no noise to speak of

using PartMeans = std::array<test::RunningMean, kParts.size()>;

/// Of the layer `indirect`, over films of their own seeds from `first_seed` on.
template <class M>
PartMeans part_means(const Scene& scene, test::RenderSettingsOf<M> settings, uint64_t first_seed, uint64_t films) {
    settings.size = {kSide, kSide};
    PartMeans means;
    for (uint64_t film = 0; film < films; ++film) {
        settings.seed = first_seed + film;
        const std::vector<float> indirect = test::render(scene, settings).resolve(Layer::Indirect);
        for (size_t k = 0; k < kParts.size(); ++k) {
            const Part& part = kParts[k];
            std::vector<float> seen;
            for (uint32_t row = part.top; row < part.bottom; ++row)
                seen.insert(seen.end(), indirect.begin() + 3 * (row * kSide + part.left),
                            indirect.begin() + 3 * (row * kSide + part.right));
            means[k].add(test::mean_of(seen));
        }
    }
    return means;
}

test::RenderSettingsOf<SvoManyLights> many_lights(uint32_t passes) {
    test::RenderSettingsOf<SvoManyLights> settings;
    settings.passes = passes;
    settings.params.vpls = 128;
    settings.params.map_resolution = 32;
    settings.params.caustic_photons = 20'000;
    return settings;
}

/// |difference| <= what is allowed + noise, which must let `must_notice` be noticed.
void expect_equal(const PartMeans& expected, const PartMeans& found, uint64_t films,
                  const std::array<double, kParts.size()>& must_notice) {
    const double t = test::two_sided_t(test::share_of_false_alarm(kFalseAlarm, kChecks), double(films) - 1);
    for (size_t k = 0; k < kParts.size(); ++k) {
        const double truth = expected[k].mean(), difference = found[k].mean() / truth - 1;
        const double sigma = std::hypot(expected[k].standard_error(), found[k].standard_error()) / truth;
        std::printf("%-24s %+.3f %%, standard error %.3f %% (many lights %.3f %%)\n", kParts[k].name, 100 * difference,
                    100 * sigma, 100 * found[k].standard_error() / truth);
        EXPECT_LE(std::abs(difference), kAllowed + t * sigma) << kParts[k].name;
        EXPECT_LE(t * sigma, must_notice[k]) << kParts[k].name << ": too noisy to notice a defect";
    }
}

void expect_as_by_paths(uint64_t films, uint32_t passes, uint32_t path_passes,
                        const std::array<double, kParts.size()>& must_notice) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    test::RenderSettings paths;
    paths.passes = path_passes;
    expect_equal(part_means(scene, paths, 1001, films), part_means(scene, many_lights(passes), 1, films), films,
                 must_notice);
}

TEST(SvoManyLightsCaustic, AgreesWithPathTracing) { expect_as_by_paths(16, 5, 64, {0.08, 0.2, 0.25}); }

TEST(SvoManyLightsCausticLong, AgreesWithPathTracing) { expect_as_by_paths(32, 64, 2048, {0.01, 0.03, 0.05}); }

TEST(SvoManyLightsCaustic, PointLightsSendThemToo) {
    Scene scene = make_builtin_scene("cornell-box-glass");
    for (Material& material : scene.materials) material.emission = Rgb(0);
    PunctualLight& light = scene.punctual_lights.emplace_back();
    light.position = scene.bounds.centre() + vec3(0.1f, 0.35f, 0.05f) * scene.bounds.diagonal();
    finish_scene(scene);
    constexpr uint64_t kFilms = 12;
    test::RenderSettingsOf<PhotonMapping> photons;
    photons.params.photons = 20'000;
    photons.params.gather_rays = 4;
    photons.passes = 2;
    const PartMeans expected = part_means(scene, photons, 1001, kFilms);
    const PartMeans found = part_means(scene, many_lights(3), 1, kFilms);
    expect_equal(expected, found, kFilms, {0.15, 0.35, 0.25});
    auto path_traced = many_lights(2);
    path_traced.params.caustic_photons = 0;
    EXPECT_LT(part_means(scene, path_traced, 1, 2)[1].mean(), 0.8 * expected[1].mean()) << "nothing to find here";
}

}  // namespace
}  // namespace photond::svo_many_lights_caustic_test
