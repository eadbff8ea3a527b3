// What is known of the densities of lights, against what the two samplers draw and carry.

#include "renderer/transport/light_ends.h"

#include <gtest/gtest.h>

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/transport/emission.h"
#include "renderer/transport/environment_sampling.h"
#include "tests/support/lit_rooms.h"

namespace photond::light_ends_test {
namespace {

struct Lit {
    Scene scene = test::room_of_all_lights();
    LightSampler lights{scene, EnvironmentDensity::Compensated};
    EmissionSampler emission{scene};
    LightEnds ends{scene, lights, emission};
};

void expect_ratio(float a, float b) { EXPECT_NEAR(a / b, 1, 1e-3f); }

TEST(LightEnds, EmissionIsWhatPhotonsCarryLightOver) {
    const Lit lit;
    RandomStream random(5, RandomDomain::Test, 0, 0);
    std::vector<size_t> seen(lit.emission.lights());
    for (int i = 0; i < 20'000; ++i) {
        EmissionSample sample;
        if (!lit.emission.sample(random.next(), random.next_2d(), random.next_2d(), sample)) continue;
        ++seen[sample.light];
        const LightEnd end = lit.ends.of_emission(sample);
        const Scene& scene = lit.scene;
        const size_t triangles = scene.triangle_lights.size();
        Rgb sent;  // radiance, intensity or irradiance
        if (sample.light < triangles) {
            sent = scene.triangle_lights[sample.light].radiance;
        } else if (sample.light < triangles + scene.punctual_lights.size()) {
            const PunctualLight& light = scene.punctual_lights[sample.light - triangles];
            sent = light.intensity;
            if (light.kind == PunctualLight::Kind::Spot)
                sent *= SpotCone(light).falloff(glm::dot(light.direction, sample.ray.direction));
            if (!(max_component(sent) > 1e-3f)) continue;  // the rim of a cone, where both are nearly 0
        } else {
            sent = lit.lights.environment_radiance(-sample.ray.direction);
        }
        expect_ratio(sample.power_w.x * end.emission, sent.x * end.cosine);
    }
    for (const size_t count : seen) EXPECT_GT(count, 20u);
}

TEST(LightEnds, OneLightHasTheSameDensitiesWhoeverFindsIt) {
    const Lit lit;
    MemoryBudget budget;
    Stats stats;
    const auto intersector = make_embree_intersector(lit.scene, budget, stats);
    RandomStream random(6, RandomDomain::Test, 0, 0);
    size_t met = 0, points = 0, suns = 0, skies = 0;
    const uint32_t first_punctual = light_source_of_punctual(lit.scene, 0);
    for (int i = 0; i < 20'000; ++i) {
        const vec3 p(3 * random.next() - 1.5f, 0.01f, 3 * random.next() - 1.5f), n(0, 1, 0);
        LightSample sample;
        if (!lit.lights.sample(p, n, random.next(), random.next_2d(), sample)) continue;
        float pdf_direct_sa = 0;
        const LightEnd end = lit.ends.of_sample(sample, pdf_direct_sa);
        ASSERT_EQ(end.delta, sample.delta);
        if (!sample.delta && end.infinite) {
            ++skies;
            const LightEnd by_ray = lit.ends.of_environment(p, n, sample.wi);
            expect_ratio(by_ray.direct, end.direct);
            expect_ratio(by_ray.emission, end.emission);
        } else if (!sample.delta) {
            const Hit hit = intersector->closest_hit({p, sample.wi, kInfinity});
            if (!hit.valid() || std::fabs(hit.t / sample.distance - 1) > 1e-4f) continue;  // hidden
            ++met;
            const LightEnd by_ray = lit.ends.on_triangle(p, n, hit.instance, hit.triangle, sample.wi, hit.t);
            expect_ratio(by_ray.direct, end.direct);
            expect_ratio(by_ray.emission, end.emission);
            expect_ratio(by_ray.cosine, end.cosine);
            expect_ratio(pdf_direct_sa, end.direct * sqr(sample.distance) / end.cosine);
        } else {
            EmissionSample emitted;
            emitted.light = static_cast<uint32_t>(lit.scene.triangle_lights.size()) + sample.source - first_punctual;
            emitted.ray.direction = -sample.wi;
            expect_ratio(lit.ends.of_emission(emitted).emission, end.emission);
            expect_ratio(lit.ends.direct_at_first_hit(emitted, p, n, sample.distance), end.direct);
            end.infinite ? ++suns : ++points;
        }
    }
    for (const size_t count : {met, points, suns, skies}) EXPECT_GT(count, 300u);
}

}  // namespace
}  // namespace photond::light_ends_test
