// Beams drawn as volumes against those that clusters of points go through.

#include <gtest/gtest.h>

#include "renderer/methods/photon_splatting/photon_splatting_gpu.h"
#include "renderer/methods/photon_splatting/splat_volumes.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/gpu_render.h"

namespace photond::gpu_splat_volumes_test {
namespace {

using Beams = PhotonSplattingGpu::Beams;

struct Rendered {
    Film film;
    Stats stats;
};

Rendered render(const test::SceneOnDevice& where, const test::RenderSettingsOf<PhotonSplattingGpu>& settings,
                Beams beams) {
    Rendered rendered{Film(settings.size, settings.layers), {}};
    MemoryBudget budget;
    PhotonSplattingGpu method(settings.params, beams);
    method.begin({where.scene, &where.intersector, test::view_of(where.scene, settings), settings.seed, budget,
                  &where.device_scene},
                 rendered.stats);
    Film again = rendered.film;
    Stats stats;
    for (uint32_t pass = 0; pass < settings.passes; ++pass) {
        method.run_pass(pass, rendered.stats, CancelToken{});
        method.resolve(rendered.film);
        method.run_pass(pass, stats, CancelToken{});
        method.resolve(again);
    }
    EXPECT_EQ(again.pixel_hash(), rendered.film.pixel_hash());
    return rendered;
}

test::RenderSettingsOf<PhotonSplattingGpu> settings_of(SplatWeighting weighting) {
    test::RenderSettingsOf<PhotonSplattingGpu> settings;
    settings.size = {61, 43};
    settings.passes = 2;
    settings.layers.add(Layer::Overlap);
    settings.params.photons = 500;
    settings.params.bounces = 2;
    settings.params.estimator = SplatEstimator::Kernel;
    settings.params.weighting = weighting;
    settings.params.filter = SplatFilter::Tent;
    settings.params.shadow_resolution = 8;
    return settings;
}

class GpuSplatVolumes : public testing::TestWithParam<SplatWeighting> {};

// The same splats reach the same points: what they bring is added in the same order, but compiled by itself.
TEST_P(GpuSplatVolumes, MakeTheImageOfClusters) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    const auto settings = settings_of(GetParam());
    const Rendered clusters = render(where, settings, Beams::Clusters),
                   volumes = render(where, settings, Beams::Volumes);
    EXPECT_GT(clusters.stats.counts.splat_contributions, 5'000u);
    EXPECT_EQ(clusters.stats.counts.splat_contributions, volumes.stats.counts.splat_contributions);
    EXPECT_EQ(clusters.film.resolve(Layer::Overlap), volumes.film.resolve(Layer::Overlap));
    const std::vector<float> a = clusters.film.resolve(Layer::Indirect), b = volumes.film.resolve(Layer::Indirect);
    for (size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 1e-5f * (a[i] + 1e-3f)) << i;
}
INSTANTIATE_TEST_SUITE_P(Weightings, GpuSplatVolumes,
                         testing::Values(SplatWeighting::Radiometric, SplatWeighting::Normalised));

TEST(GpuSplatVolumes, WhereTheyCannotBeDrawnClustersAreTaken) {
    Camera camera;
    const Needs lambert;
    EXPECT_TRUE(SplatVolumes::possible(lambert, camera));
    camera.aperture_radius_m = 0.1f;
    EXPECT_FALSE(SplatVolumes::possible(lambert, camera));
    camera = {.orthographic = true};
    EXPECT_FALSE(SplatVolumes::possible(lambert, camera));
    Needs delta;
    delta.delta = true;
    EXPECT_FALSE(SplatVolumes::possible(delta, Camera{}));
}

}  // namespace
}  // namespace photond::gpu_splat_volumes_test
