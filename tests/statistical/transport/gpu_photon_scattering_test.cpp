// What photon_scattering_test.cpp asks of the C++, asked of its GLSL twin: fewer materials, as software devices take
// their time.

#include "tests/support/gpu_photon_scattering.h"
#include "tests/support/photon_scattering_checks.h"

namespace photond::gpu_photon_scattering_test {
namespace {

using namespace test;

TEST(GpuPhotonScattering, CarriesWhatTheEyeFinds) {
    const Scene* uploaded = nullptr;
    std::unique_ptr<GpuPhotonScattering> gpu;
    const ScatterMany scatter = [&](const Scene& scene, const Case& c, float outside_ior, const vec3& wi,
                                    std::span<const vec3> numbers) {
        // Each scene is asked for several directions one after the other.
        if (wi == kLights[0] || uploaded != &scene) gpu = std::make_unique<GpuPhotonScattering>(scene);
        uploaded = &scene;
        std::vector<ScatteringQuery> queries;
        for (const vec3& n : numbers) queries.push_back({wi, n, wi});
        std::vector<PhotonScattering> scattered;
        for (const ScatteringAnswer& a : gpu->scatter(kHit, c.part, outside_ior, queries))
            scattered.push_back(a.scattering);
        return scattered;
    };
    const std::vector<Case> all = cases();
    const std::vector<Normals> leaning = {Normals::LeaningAndMapped};
    const size_t below =
        expect_photons_carry_what_the_eye_finds(scatter, {all[0], all[1], all[4], all[6]}, leaning, 20'000, 1e-6);
    EXPECT_GT(below, 5u);
}

}  // namespace
}  // namespace photond::gpu_photon_scattering_test
