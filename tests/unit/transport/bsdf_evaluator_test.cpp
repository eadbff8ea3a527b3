// What the evaluator says of many directions against what the BSDF says of each.

#include "renderer/transport/bsdf_evaluator.h"

#include <gtest/gtest.h>

#include "renderer/core/rng.h"
#include "tests/support/bsdf_quadrature.h"

namespace photond::bsdf_evaluator_test {
namespace {

vec3 random_direction(RandomStream& random, float least_cos) {
    const float z = least_cos + (1 - least_cos) * random.next();
    return vec3(test::direction_at(static_cast<double>(z), static_cast<double>(random.next())));
}

/// Any mixture of lobes; roughness from delta to 1.
Bsdf random_bsdf(RandomStream& random) {
    const auto sometimes = [&](float value) { return random.next() < 0.5f ? value : 0.0f; };
    const auto colour = [&] { return Rgb(random.next(), random.next(), random.next()); };
    Bsdf::Parameters p;
    p.geometric_normal = random_direction(random, 0.8f);
    p.base_color = colour();
    if (random.next() < 0.1f) return Bsdf::lambert(p.geometric_normal, p.base_color);
    p.metallic = sometimes(random.next());
    p.roughness = sometimes(random.next());
    p.ior = 1 + sometimes(random.next());
    p.specular = sometimes(random.next());
    p.specular_color = 1.5f * colour();
    p.transmission = sometimes(random.next());
    p.solid = random.next() < 0.5f;
    p.eta = 0.6f + random.next();
    const Bsdf bsdf = Bsdf::layered(p);
    const float part = random.next();
    return part < 0.2f ? bsdf.rough_part(0.1f) : part < 0.4f ? bsdf.specular_part(0.1f) : bsdf;
}

TEST(BsdfEvaluator, SaysOfManyDirectionsWhatTheBsdfSaysOfEach) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    int lit = 0, transmitted = 0, peaks = 0;
    for (int i = 0; i < 20'000; ++i) {
        const Bsdf bsdf = random_bsdf(random);
        const vec3 wo = random_direction(random, i % 50 ? 0.0f : -1.0f);
        const BsdfEvaluator evaluator(bsdf, wo);
        std::array<vec3, kLanes> directions;
        Vec3Lanes wi;
        for (size_t k = 0; k < kLanes; ++k) {
            // Near the mirrored direction as often as anywhere, where narrow lobes are.
            vec3 d = random_direction(random, i % 3 ? 0.0f : -1.0f);
            if (k % 2) d = glm::normalize(vec3(-wo.x, -wo.y, std::copysign(wo.z, d.z)) + 0.1f * d);
            directions[k] = d;
            wi.x[k] = d.x, wi.y[k] = d.y, wi.z[k] = d.z;
        }
        const Vec3Lanes f_cos = evaluator.f_cos(wi);
        for (size_t k = 0; k < kLanes; ++k) {
            const Rgb expected = bsdf.f_cos(wo, directions[k]), value(f_cos.x[k], f_cos.y[k], f_cos.z[k]);
            for (int c = 0; c < 3; ++c) ASSERT_NEAR(value[c], expected[c], 3e-5f * max_component(expected)) << i;
            lit += !is_black(expected);
            transmitted += directions[k].z < 0 && !is_black(expected);
            peaks += max_component(expected) > 10;
        }
    }
    EXPECT_GT(lit, 50'000);
    EXPECT_GT(transmitted, 3000);
    EXPECT_GT(peaks, 300);
}

TEST(BsdfEvaluator, IsBlackWhereNothingIsScattered) {
    const Vec3Lanes up = broadcast({0, 0, 1});
    const vec3 normal(0, 0, 1);
    const auto is_zero = [&](const Bsdf& bsdf, const vec3& wo, const Vec3Lanes& wi) {
        const Vec3Lanes f = BsdfEvaluator(bsdf, wo).f_cos(wi);
        return all_of(f.x == 0 && f.y == 0 && f.z == 0);
    };
    EXPECT_TRUE(is_zero(Bsdf(), normal, up));
    EXPECT_TRUE(is_zero(Bsdf::lambert(normal, Rgb(1)), -normal, up));
    EXPECT_TRUE(is_zero(Bsdf::layered({}), -normal, up));
    EXPECT_TRUE(is_zero(Bsdf::layered({.metallic = 1, .roughness = 0}), normal, up));
    // The half-vector of opposite directions along the surface has no direction.
    const Vec3Lanes f = BsdfEvaluator(Bsdf::layered({}), {1, 0, 1e-20f}).f_cos(broadcast({-1, 0, 0}));
    EXPECT_TRUE(all_of(f.x == 0));
}

}  // namespace
}  // namespace photond::bsdf_evaluator_test
