// The GLSL twins of BSDFs say and draw what the C++ does, to rounding.

#include <gtest/gtest.h>

#include "tests/support/gpu_bsdf.h"
#include "tests/support/random_materials.h"

namespace photond::gpu_twins_bsdf_test {
namespace {

using namespace test;

constexpr size_t kCases = 20'000;

std::vector<BsdfCase> random_cases(RandomStream& random) {
    std::vector<BsdfCase> cases(kCases);
    for (BsdfCase& c : cases) {
        c.parameters = random_material(random);
        c.part = BsdfPart(random.next_bits() % 3);
        c.glossy_threshold = random.next();
        c.mode = random.next_bits() % 2 ? TransportMode::Radiance : TransportMode::Importance;
        if (random.next_bits() % 16 == 0) c.parameters.eta = c.parameters.ior = 0;  // reflects all
        if (random.next_bits() % 16 == 0) c.parameters.eta = c.parameters.ior = 1;  // no interface
    }
    return cases;
}

/// How far two colours are apart, over the larger's greatest channel; 0 of two black ones.
float relative_difference(const Rgb& a, const Rgb& b) {
    const float most = std::max(max_component(glm::abs(a)), max_component(glm::abs(b)));
    return most > 0 ? max_component(glm::abs(a - b)) / most : 0.0f;
}
float relative_difference(float a, float b) { return relative_difference(Rgb(a), Rgb(b)); }

// Values differ by what rounding makes of a half-vector: the narrower the lobe (or the less a refraction bends), the
// more its exact place matters. A rounding error e of a direction moves a lobe of width alpha by e / alpha.
float value_tolerance(const Bsdf::Parameters& p) {
    const float width = sqr(p.roughness) * (p.solid ? std::min(1.0f, std::fabs(p.eta - 1)) : 1.0f);
    return 2e-5f + 2e-6f / std::max(width, 1e-5f);
}

TEST(GpuTwinsBsdf, ValuesAreThoseOfTheCpu) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    const std::vector<BsdfCase> cases = random_cases(random);
    std::vector<BsdfQuery> queries;
    for (size_t i = 0; i < kCases; ++i) {
        const vec3 wo = random_direction(random, 0);
        // Near the mirrored direction as often as anywhere, where narrow lobes are.
        vec3 wi = random_direction(random, -1);
        if (i % 2) wi = glm::normalize(vec3(-wo.x, -wo.y, std::copysign(wo.z, wi.z)) + 0.1f * wi);
        queries.push_back({static_cast<uint32_t>(i), wo, wi});
    }
    const std::vector<BsdfValue> values = GpuBsdfs().evaluate(cases, queries);
    int lit = 0, transmitted = 0, exact = 0;
    for (size_t i = 0; i < kCases; ++i) {
        const BsdfQuery& q = queries[i];
        const BsdfValue expected = cases[i].make().evaluate(q.wo, q.w, cases[i].mode);
        const float tolerance = value_tolerance(cases[i].parameters);
        ASSERT_LE(relative_difference(values[i].f_cos, expected.f_cos), tolerance) << i;
        ASSERT_LE(relative_difference(values[i].pdf_sa, expected.pdf_sa), tolerance) << i;
        lit += !is_black(expected.f_cos), transmitted += q.w.z < 0 && !is_black(expected.f_cos);
        exact += relative_difference(values[i].f_cos, expected.f_cos) < 1e-5f;
    }
    EXPECT_GT(lit, 5000);
    EXPECT_GT(transmitted, 500);
    EXPECT_GT(exact, 19'000);
}

TEST(GpuTwinsBsdf, SamplesAreThoseOfTheCpu) {
    RandomStream random(2, RandomDomain::Test, 0, 0);
    const std::vector<BsdfCase> cases = random_cases(random);
    std::vector<BsdfQuery> queries;
    for (size_t i = 0; i < kCases; ++i) {
        const vec3 wo = random_direction(random, 0);
        const float u_lobe = random.next();
        queries.push_back({static_cast<uint32_t>(i), wo, vec3(u_lobe, random.next_2d())});
    }
    const std::vector<BsdfSample> samples = GpuBsdfs().sample(cases, queries);
    int valid = 0, delta = 0, refracted = 0, other_choice = 0;
    for (size_t i = 0; i < kCases; ++i) {
        const BsdfQuery& q = queries[i];
        const BsdfSample &s = samples[i],
                         expected = cases[i].make().sample(q.wo, q.w.x, vec2(q.w.y, q.w.z), cases[i].mode);
        // On the border between two lobes, or between a surface's sides, rounding decides.
        if (s.valid() != expected.valid() || s.delta != expected.delta || s.transmission != expected.transmission ||
            s.refraction != expected.refraction) {
            ++other_choice;
            continue;
        }
        if (!expected.valid()) continue;
        ++valid, delta += s.delta, refracted += s.refraction;
        ASSERT_LE(glm::distance(s.wi, expected.wi), 2e-5f) << i;
        ASSERT_EQ(s.eta, expected.eta) << i;
        // And the directions differ by rounding, which grazing cosines feel.
        const float tolerance = value_tolerance(cases[i].parameters) + 2e-6f / std::fabs(s.wi.z);
        ASSERT_LE(relative_difference(s.weight, expected.weight), tolerance) << i;
        ASSERT_LE(relative_difference(s.pdf_sa, expected.pdf_sa), tolerance) << i;
    }
    EXPECT_LE(other_choice, 3);
    EXPECT_GT(valid, 10'000);
    EXPECT_GT(delta, 2000);
    EXPECT_GT(refracted, 500);
}

TEST(GpuTwinsBsdf, TraitsAreThoseOfTheCpu) {
    RandomStream random(3, RandomDomain::Test, 0, 0);
    const std::vector<BsdfCase> cases = random_cases(random);
    const std::vector<BsdfTraits> traits = GpuBsdfs().traits(cases);
    for (size_t i = 0; i < kCases; ++i) {
        const Bsdf bsdf = cases[i].make();
        const BsdfTraits& t = traits[i];
        ASSERT_LE(relative_difference(t.albedo, bsdf.albedo()), 1e-5f) << i;
        ASSERT_EQ(t.refraction_eta, bsdf.refraction_eta()) << i;
        ASSERT_EQ(t.scatters, bsdf.scatters()) << i;
        ASSERT_EQ(t.is_lambert, bsdf.is_lambert()) << i;
        ASSERT_EQ(t.has_non_delta, bsdf.has_non_delta()) << i;
        ASSERT_EQ(t.has_delta, bsdf.has_delta()) << i;
        ASSERT_EQ(t.has_non_delta_transmission, bsdf.has_non_delta_transmission()) << i;
        ASSERT_EQ(t.is_diffuse, bsdf.is_diffuse()) << i;
    }
}

}  // namespace
}  // namespace photond::gpu_twins_bsdf_test
