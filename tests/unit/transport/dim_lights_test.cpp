// Light paths start from every light, and shadow rays go to every light, however dim it is beside another.

#include <gtest/gtest.h>

#include "renderer/core/rng.h"
#include "renderer/scene/hard_case_answers.h"
#include "renderer/scene/mesh_builder.h"
#include "renderer/transport/emission_sampling.h"
#include "renderer/transport/light_sampling.h"

namespace photond::dim_lights_test {
namespace {

/// A rectangle of two triangles for each strength, of one area; a light's own two have different ones.
Scene lamps(const std::vector<float>& strengths) {
    Scene scene;
    for (const float strength : strengths) {
        const float x = static_cast<float>(2 * scene.meshes.size());
        Material material;
        material.emission = Rgb(strength);
        scene.meshes.push_back(MeshBuilder()
                                   .triangle({x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0})
                                   .triangle({x, 0, 1}, {x + 1, 0, 1}, {x, 3, 1})
                                   .build(static_cast<uint32_t>(scene.materials.size())));
        scene.materials.push_back(material);
        Instance instance;
        instance.mesh = static_cast<uint32_t>(scene.instances.size());
        scene.instances.push_back(instance);
    }
    finish_scene(scene);
    return scene;
}

TEST(DimLights, AnEqualPartOfTheSixteenthIsThatOfEachLamp) {
    const Scene scene = lamps({1, 1e-14f, 1});
    const EmissionSampler sampler(scene);
    const double of_bright = (1 - 1.0 / 16) / 2 + 1.0 / 48, of_dim = 1.0 / 48;
    const double expected[] = {of_bright / 4,  3 * of_bright / 4, of_dim / 4,
                               3 * of_dim / 4, of_bright / 4,     3 * of_bright / 4};
    ASSERT_EQ(sampler.lights(), 6u);
    for (uint32_t i = 0; i < 6; ++i) EXPECT_NEAR(static_cast<double>(sampler.probability(i)), expected[i], 3e-7) << i;
}

TEST(DimLights, LampsOfOnePowerAreChosenByPowerAlone) {
    for (const std::vector<float>& strengths : {std::vector<float>{2}, std::vector<float>{2, 2, 2, 2}}) {
        const Scene scene = lamps(strengths);
        const EmissionSampler sampler(scene);
        for (uint32_t i = 0; i < sampler.lights(); ++i)
            EXPECT_NEAR(sampler.probability(i), (i % 2 ? 0.75f : 0.25f) / static_cast<float>(strengths.size()), 3e-7f);
    }
}

TEST(DimLights, NoPathCarriesMoreThanByPowerAloneButForTheSixteenth) {
    const Scene scene = lamps({1, 1e-14f, 1e-3f, 20});
    const EmissionSampler sampler(scene);
    RandomStream random(1, RandomDomain::Test, 0, 0);
    size_t dim = 0;
    double dim_w = 0;
    constexpr size_t kPaths = 20'000;
    for (size_t i = 0; i < kPaths; ++i) {
        EmissionSample sample;
        const float u_light = random.next();
        const vec2 position(random.next(), random.next()), direction(random.next(), random.next());
        ASSERT_TRUE(sampler.sample(u_light, position, direction, sample));
        EXPECT_LE(static_cast<double>(sample.power_w.x), 1.0001 * 16 / 15 * sampler.total_power_w());
        if (sample.source == 1) ++dim, dim_w += static_cast<double>(sample.power_w.x) / kPaths;
    }
    // 1 / 64 of the paths, each with 64 times the lamp's power of 2 pi 1e-14 W: sigma is 5.7 %, so 30 % is 5.3 of them.
    EXPECT_GT(dim, kPaths / 128);
    EXPECT_NEAR(dim_w / (2 * double{kPi} * 1e-14), 1, 0.3);
}

TEST(DimLights, ShadowRaysGoToADimLampBesideABrightOne) {
    // Lamps face +z. Their importances at the point are 1e14 apart; a board that hides the bright one is not asked for.
    const Scene scene = lamps({1e-6f, 1e8f});
    const LightSampler sampler(scene);
    const vec3 p(0.5f, 0.5f, 3), n(0, 0, -1);
    RandomStream random(2, RandomDomain::Test, 0, 0);
    constexpr size_t kSamples = 100'000;
    size_t dim = 0;
    double dim_irradiance = 0;
    for (size_t i = 0; i < kSamples; ++i) {
        LightSample sample;
        const float u_select = random.next();
        if (!sampler.sample(p, n, u_select, {random.next(), random.next()}, sample) || sample.source != 0) continue;
        ++dim;
        dim_irradiance += static_cast<double>(sample.radiance_over_pdf.x * glm::dot(n, sample.wi)) / kSamples;
    }
    EXPECT_NEAR(static_cast<double>(dim) / kSamples, 1.0 / 128, 5.3 * std::sqrt(1.0 / 128 / kSamples));
    double expected = 0;
    for (const dvec3& apex : {dvec3(0, 1, 0), dvec3(0, 3, 1)}) {
        const dvec3 corners[] = {{0, 0, apex.z}, apex, {1, 0, apex.z}};
        expected += 1e-6 * std::abs(polygon_irradiance(dvec3(p), dvec3(n), corners));
    }
    // Of some 780 samples, whose irradiances are within a factor of a few: sigma is below 5 %.
    EXPECT_NEAR(dim_irradiance / expected, 1, 0.25);
}

}  // namespace
}  // namespace photond::dim_lights_test
