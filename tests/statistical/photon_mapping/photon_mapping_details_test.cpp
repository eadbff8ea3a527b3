// Photon mapping at its defaults in what stands at the foot of walls and hangs on them, against path tracing: the mean
// of the indirect light, and that of each band of rows. Whole discs lose up to a sixth of it here, and discs clipped at
// every edge, sheets behind sheets included, were a fifth too bright.
//
// Films of different seeds are the samples: photons are shared by all pixels of a pass.

#include <gtest/gtest.h>

#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/path_render.h"
#include "tests/support/statistics.h"

namespace photond::photon_mapping_details_test {
namespace {

constexpr Size2 kSize{64, 48};
constexpr size_t kBands = 8;
constexpr double kFalseAlarm = 1e-6;
constexpr size_t kChecks = 2 * 7 * 4 * (kBands + 1);  // short and long, of scenes, gathers and photons

/// Mean indirect light by band of rows, and of the whole image.
template <class M>
std::array<test::RunningMean, kBands + 1> band_means(const Scene& scene, test::RenderSettingsOf<M> settings,
                                                     uint32_t films) {
    std::array<test::RunningMean, kBands + 1> means;
    settings.size = kSize;
    for (uint32_t film = 0; film < films; ++film) {
        settings.seed = 100 + film;
        const std::vector<float> light = test::render(scene, settings).resolve(Layer::Indirect);
        std::array<double, kBands + 1> sums{};
        for (size_t i = 0; i < light.size(); ++i) {
            sums[i * kBands / light.size()] += double{light[i]};
            sums[kBands] += double{light[i]};
        }
        for (size_t band = 0; band <= kBands; ++band)
            means[band].add(sums[band] * (band < kBands ? kBands : 1) / static_cast<double>(light.size()));
    }
    return means;
}

struct Run {
    uint32_t films, path_passes, photon_passes;
    double must_notice;  // of the whole image
};

/// The mean within 1 %, every band within `allowed`.
void compare(std::string_view name, Gather gather, uint32_t photons, double allowed, const Run& run) {
    const Scene scene = make_builtin_scene(name);
    test::RenderSettings paths;
    paths.passes = run.path_passes;
    test::RenderSettingsOf<PhotonMapping> mapping;
    mapping.passes = run.photon_passes;
    mapping.params.gather = gather;
    mapping.params.photons = photons;
    const auto expected = band_means(scene, paths, run.films), measured = band_means(scene, mapping, run.films);
    const double t = test::two_sided_t(test::share_of_false_alarm(kFalseAlarm, kChecks), 2.0 * run.films - 2);
    for (size_t band = 0; band <= kBands; ++band) {
        const double truth = expected[band].mean(), off = measured[band].mean() / truth - 1;
        const double noise = t * std::hypot(expected[band].standard_error(), measured[band].standard_error()) / truth;
        const bool whole = band == kBands;
        EXPECT_LE(std::abs(off), (whole ? 0.01 : allowed) + noise) << name << ", band " << band;
        if (!whole) continue;
        EXPECT_LE(noise, run.must_notice) << "too noisy to notice a defect";
        std::printf("%.*s, gather %d, %u photons: %+.3f %% +- %.3f %%\n", int(name.size()), name.data(), int(gather),
                    photons, 100 * off, 100 * noise);
    }
}

constexpr Run kShort{8, 24, 4, 0.04}, kLong{16, 256, 24, 0.01};

TEST(PhotonMappingDetails, MeansAreThoseOfPathTracing) {
    compare("details/stepped-bars", Gather::Direct, 10'000, 0.1, kShort);
    compare("details/books", Gather::Final, 10'000, 0.1, kShort);
}

TEST(PhotonMappingDetailsLong, MeansAreThoseOfPathTracing) {
    for (const std::string_view name : builtin_scene_names("details"))
        for (const Gather gather : {Gather::Direct, Gather::Final})
            for (const uint32_t photons : {10'000u, 200'000u}) compare(name, gather, photons, 0.1, kLong);
}

}  // namespace
}  // namespace photond::photon_mapping_details_test
