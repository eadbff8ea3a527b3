// Beams on a GPU are as wide as the CPU's: the same numbers make the same light about a glass on a large floor. That it
// is the right one, and no glow, is the CPU's test.

#include <gtest/gtest.h>

#include "renderer/methods/photon_splatting/photon_splatting_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/gpu_render.h"

namespace photond::gpu_photon_splatting_glow_test {
namespace {

constexpr uint32_t kPasses = 4;

template <class M>
test::RenderSettingsOf<M> settings_for() {
    test::RenderSettingsOf<M> settings;
    settings.passes = kPasses;
    settings.params.sampler = SamplerKind::Random;
    return settings;
}

TEST(GpuPhotonSplattingGlow, ItsBeamsAreTheCpus) {
    const Scene scene = make_builtin_scene("caustics/glass-on-floor");
    const test::SceneOnDevice where(scene);
    Stats stats;
    const Film cpu = test::render(scene, settings_for<PhotonSplatting>(), &stats);
    const Film gpu = test::render(where, settings_for<PhotonSplattingGpu>());
    const double expected = test::mean_of(cpu.resolve(Layer::Indirect));
    ASSERT_GT(expected, 0);
    ASSERT_GT(stats.counts.splat_contributions, 100u);
    // Rounding sends some paths elsewhere.
    EXPECT_NEAR(test::mean_of(gpu.resolve(Layer::Indirect)) / expected, 1, 0.01);
}

}  // namespace
}  // namespace photond::gpu_photon_splatting_glow_test
