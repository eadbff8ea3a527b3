// What bsdf_energy_test.cpp and microfacet_test.cpp ask of the C++, asked of its GLSL twin: fewer angles, as software
// devices take their time.

#include "tests/support/bsdf_energy_checks.h"
#include "tests/support/bsdf_reciprocity_checks.h"
#include "tests/support/gpu_bsdf.h"

namespace photond::gpu_bsdf_energy_test {
namespace {

using namespace test;

TEST(GpuBsdfEnergy, NothingScattersMoreThanItGets) {
    expect_nothing_scatters_more_than_it_gets(GpuBsdfs(), {0.0f, 0.01f, 0.2f, 1.0f}, {1, 0.1});
}

TEST(GpuBsdfEnergy, MirrorsAndClearGlassLoseNothing) {
    expect_mirrors_and_clear_glass_lose_nothing(GpuBsdfs(), {1, 0.6, 0.1});
}

TEST(GpuBsdfEnergy, OneBounceOfGgxIsItsDirectionalAlbedo) {
    expect_one_bounce_of_ggx_is_its_albedo(GpuBsdfs(), 1e-6, 100'000, {0.01f, 0.1f, 0.5f, 1.0f}, {1, 0.3, 0.03});
}

TEST(GpuBsdfReciprocity, ReflectionIsSymmetricAndRefractionScalesWithTheIndex) { expect_reciprocity(GpuBsdfs(), 200); }

TEST(GpuBsdf, NothingIsNanFromMirrorToMattAndGrazing) { expect_no_nan(GpuBsdfs()); }

}  // namespace
}  // namespace photond::gpu_bsdf_energy_test
