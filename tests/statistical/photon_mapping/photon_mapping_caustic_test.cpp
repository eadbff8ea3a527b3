// Caustics: what photon mapping looks up in the caustic map, path tracing finds by chance. The box with the glass
// sphere and the mirror block under its lamp; light (lamp, delta scatterings, x_1) is the layer "caustic" of both. The
// mean of a region is compared: photon mapping only smears light within its radius, and the regions' borders lie where
// the caustic is even or nil.

#include <gtest/gtest.h>

#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/path_render.h"
#include "tests/support/statistics.h"

namespace photond::photon_mapping_caustic_test {
namespace {

constexpr Size2 kSize{96, 96};
constexpr double kFalseAlarm = 1e-6;

/// A rectangle of the picture, in fractions of its sides.
struct Region {
    const char* name;
    double x0, y0, x1, y1;
};
// Seen in the picture: under the sphere, and the block's reflection of the lamp on ceiling and wall.
constexpr Region kRegions[] = {{"floor about the sphere", 0.4, 0.86, 0.95, 1.0},
                               {"ceiling above the block", 0.05, 0.0, 0.6, 0.3},
                               {"whole picture", 0, 0, 1, 1}};
constexpr size_t kChecks = 3 * std::size(kRegions);

double region_mean(const std::vector<float>& image, const Region& region, size_t channel) {
    double sum = 0;
    size_t count = 0;
    for (auto y = size_t(region.y0 * kSize.height); y < size_t(region.y1 * kSize.height); ++y)
        for (auto x = size_t(region.x0 * kSize.width); x < size_t(region.x1 * kSize.width); ++x, ++count)
            sum += image[3 * (y * kSize.width + x) + channel];
    return sum / double(count);
}

/// Means of the regions over films of their own passes, each of its own seed.
template <class M>
std::array<std::array<test::RunningMean, 3>, std::size(kRegions)> region_means(test::RenderSettingsOf<M> settings,
                                                                               uint64_t films) {
    const Scene scene = make_builtin_scene("cornell-box-glass");
    settings.size = kSize;
    settings.layers.add(Layer::Caustic);
    std::array<std::array<test::RunningMean, 3>, std::size(kRegions)> means;
    for (uint64_t seed = 1; seed <= films; ++seed) {
        settings.seed = seed;
        const std::vector<float> image = test::render(scene, settings).resolve(Layer::Caustic);
        for (size_t r = 0; r < std::size(kRegions); ++r)
            for (size_t c = 0; c < 3; ++c) means[r][c].add(region_mean(image, kRegions[r], c));
    }
    return means;
}

/// |difference| <= allowed + noise, where the noise (z of the false-alarm rate) must let `must_notice` be noticed.
void compare(uint64_t films, uint32_t path_passes, uint32_t photon_passes, double allowed, double must_notice) {
    test::RenderSettings paths;
    paths.passes = path_passes;
    test::RenderSettingsOf<PhotonMapping> photons;
    photons.passes = photon_passes;
    photons.params.gather = Gather::Direct;
    photons.params.search = PhotonSearch::Kind::Radius;
    photons.params.radius_m = 0.05f;
    const auto expected = region_means(paths, films);
    const auto measured = region_means(photons, films);
    const double t = test::two_sided_t(test::share_of_false_alarm(kFalseAlarm, kChecks), double(films) - 1);
    for (size_t r = 0; r < std::size(kRegions); ++r)
        for (size_t c = 0; c < 3; ++c) {
            const double truth = expected[r][c].mean(), difference = measured[r][c].mean() / truth - 1;
            const double sigma = std::hypot(expected[r][c].standard_error(), measured[r][c].standard_error()) / truth;
            std::printf("%-24s channel %zu: %+.3f %%, standard error %.3f %% (photons %.3f %%)\n", kRegions[r].name, c,
                        100 * difference, 100 * sigma, 100 * measured[r][c].standard_error() / truth);
            EXPECT_LE(std::abs(difference), allowed + t * sigma) << kRegions[r].name << ", channel " << c;
            EXPECT_LE(t * sigma, must_notice) << "too noisy to notice a defect";
        }
}

TEST(PhotonMappingCaustic, AgreesWithPathTracing) { compare(16, 24, 1, 0.01, 0.25); }

TEST(PhotonMappingCausticLong, AgreesWithPathTracing) { compare(32, 512, 16, 0.01, 0.03); }

}  // namespace
}  // namespace photond::photon_mapping_caustic_test
