// No material scatters more than it gets, at any roughness and angle; a GGX lobe alone scatters what an independent
// quadrature of the textbook formula says.

#include "renderer/transport/bsdf_albedo_table.h"
#include "tests/support/bsdf_energy_checks.h"

namespace photond::bsdf_energy_test {
namespace {

using namespace test;

const std::vector<double> kCosines = {1, 0.9, 0.6, 0.3, 0.1, 0.03, 0.003};

TEST(BsdfEnergy, NothingScattersMoreThanItGets) {
    expect_nothing_scatters_more_than_it_gets(
        CpuBsdfs(), {0.0f, 0.005f, 0.01f, 0.013f, 0.03f, 0.1f, 0.2f, 0.35f, 0.5f, 0.75f, 1.0f}, kCosines);
}

TEST(BsdfEnergy, MirrorsAndClearGlassLoseNothing) { expect_mirrors_and_clear_glass_lose_nothing(CpuBsdfs(), kCosines); }

TEST(BsdfEnergy, OneBounceOfGgxIsItsDirectionalAlbedo) {
    expect_one_bounce_of_ggx_is_its_albedo(CpuBsdfs(), 1e-6, 200'000,
                                           {0.01f, 0.013f, 0.03f, 0.1f, 0.2f, 0.35f, 0.5f, 0.75f, 1.0f}, kCosines);
}

// The table never promises the base more than the coat leaves it (but for the quadrature's error here).
TEST(BsdfEnergy, TableOfAlbedosCoversTheTruth) {
    double least = 0, greatest = 0;
    for (double root = 0.1; root < 1; root += 0.0571)
        for (double t = 0.05; t < 1; t += 0.0537) {
            const double roughness = root * root, cos_theta = std::pow(t, 4);
            const vec2 ab = AlbedoTable::get().directional(static_cast<float>(cos_theta),
                                                           AlbedoTable::row(static_cast<float>(roughness)));
            const double alpha = roughness * roughness;
            for (const double f0 : {0.0, 0.04, 1.0}) {
                const double difference = f0 * static_cast<double>(ab.x) + static_cast<double>(ab.y) -
                                          textbook_albedo(alpha, f0, 1, cos_theta);
                least = std::min(least, difference), greatest = std::max(greatest, difference);
            }
        }
    EXPECT_GE(least, -1e-4);
    EXPECT_LE(greatest, 0.01);
    // The mean over the hemisphere is that of the lookups themselves.
    for (const float roughness : {0.0f, 0.02f, 0.3f, 1.0f}) {
        const float row = AlbedoTable::row(roughness);
        glm::dvec2 sum(0);
        constexpr int kSteps = 20000;
        for (int i = 0; i < kSteps; ++i)
            sum += glm::dvec2(AlbedoTable::get().directional(static_cast<float>(std::sqrt((i + 0.5) / kSteps)), row));
        const vec2 average = AlbedoTable::get().average(row);
        EXPECT_NEAR(sum.x / kSteps, average.x, 1e-4);
        EXPECT_NEAR(sum.y / kSteps, average.y, 1e-4);
    }
}

}  // namespace
}  // namespace photond::bsdf_energy_test
