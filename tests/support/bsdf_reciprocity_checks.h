#pragma once
// That BSDFs are reciprocal and finite, checked of whoever answers (bsdf_case.h): the C++ and its GLSL twin by the same
// code.

#include <gtest/gtest.h>

#include <string>

#include "tests/support/bsdf_case.h"

namespace photond::test {

/// Directions of the upper side, by their cosine, a fifth of them grazing.
inline vec3 cosine_direction(RandomStream& random) {
    vec3 w = sample_cosine_hemisphere(random.next_2d());
    if (random.next() < 0.2f) w = glm::normalize(vec3(w.x, w.y, 0.02f * w.z));
    return w;
}

inline void expect_equal(const Rgb& a, const Rgb& b, double tolerance, const std::string& what) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance * (1e-3 + std::fabs(b[c]))) << what;
}

/// f(wo, wi) = f(wi, wo) on one side. Through the surface, f*(wo, wi) of importance is f(wi, wo) of radiance, and
/// f / eta^2 is symmetric [Veach 1997, 5.14].
template <class Bsdfs>
void expect_reciprocity(const Bsdfs& bsdfs, size_t pairs) {
    // Each BSDF looked at from one side, the same for importance, and from the other side.
    std::vector<BsdfCase> cases;
    for (const float roughness : {0.05f, 0.3f, 1.0f})
        for (const float metallic : {0.0f, 0.4f, 1.0f})
            for (const float transmission : {0.0f, 0.5f, 1.0f})
                for (const bool solid : {false, true}) {
                    BsdfCase c{.parameters = {.base_color = Rgb(0.9f, 0.4f, 0.1f),
                                              .metallic = metallic,
                                              .roughness = roughness,
                                              .specular_color = Rgb(1, 0.3f, 2),
                                              .transmission = transmission,
                                              .solid = solid}};
                    cases.push_back(c);
                    c.mode = TransportMode::Importance;
                    cases.push_back(c);
                    c.mode = TransportMode::Radiance, c.parameters.eta = 1 / c.parameters.eta;
                    cases.push_back(c);
                }
    RandomStream random(3, RandomDomain::Test, 0, 0);
    std::vector<BsdfQuery> forth, back, draws;
    for (uint32_t i = 0; i < cases.size(); i += 3)
        for (size_t k = 0; k < pairs; ++k) {
            const vec3 wo = cosine_direction(random), wi = cosine_direction(random);
            forth.push_back({i, wo, wi});
            back.push_back({i, wi, wo});
            const float u_lobe = random.next();
            draws.push_back({i, wo, vec3(u_lobe, random.next_2d())});
        }
    const auto name = [&](uint32_t which) {
        const Bsdf::Parameters& p = cases[which].parameters;
        return "roughness " + std::to_string(p.roughness) + ", metallic " + std::to_string(p.metallic) +
               ", transmission " + std::to_string(p.transmission);
    };
    // Half-vectors of float directions: relative error of a narrow lobe some 1e-7 / alpha.
    const auto tolerance = [&](uint32_t which) {
        return 2e-5 + 2e-6 / static_cast<double>(sqr(cases[which].parameters.roughness));
    };
    const std::vector<BsdfValue> there = bsdfs.evaluate(cases, forth), reversed = bsdfs.evaluate(cases, back);
    for (size_t i = 0; i < forth.size(); ++i)
        expect_equal(there[i].f_cos / forth[i].w.z, reversed[i].f_cos / back[i].w.z, tolerance(forth[i].bsdf_case),
                     name(forth[i].bsdf_case));

    const auto turned = [](const vec3& w) { return vec3(w.x, w.y, -w.z); };
    const std::vector<BsdfSample> samples = bsdfs.sample(cases, draws);
    forth.clear(), back.clear();
    std::vector<BsdfQuery> importance;
    for (size_t i = 0; i < draws.size(); ++i) {
        const BsdfSample& s = samples[i];
        if (!s.valid() || s.delta || !s.transmission) continue;
        const uint32_t which = draws[i].bsdf_case;
        forth.push_back({which, draws[i].wo, s.wi});
        importance.push_back({which + 1, draws[i].wo, s.wi});
        back.push_back({which + 2, turned(s.wi), turned(draws[i].wo)});
    }
    EXPECT_GT(forth.size(), draws.size() / 10);
    const std::vector<BsdfValue> radiances = bsdfs.evaluate(cases, forth),
                                 importances = bsdfs.evaluate(cases, importance), backs = bsdfs.evaluate(cases, back);
    for (size_t i = 0; i < forth.size(); ++i) {
        const uint32_t which = forth[i].bsdf_case;
        const Bsdf::Parameters& p = cases[which].parameters;
        const float cos_i = std::fabs(forth[i].w.z);
        expect_equal(backs[i].f_cos / forth[i].wo.z, importances[i].f_cos / cos_i, 1e-3 + 20 * tolerance(which),
                     name(which) + ", adjoint");
        expect_equal(radiances[i].f_cos / cos_i * (p.solid ? sqr(p.eta) : 1.0f), importances[i].f_cos / cos_i, 1e-5,
                     name(which) + ", index");
    }
}

/// From mirror to matt, from the horizon to straight above, at and near equal indices.
template <class Bsdfs>
void expect_no_nan(const Bsdfs& bsdfs) {
    RandomStream random(4, RandomDomain::Test, 0, 0);
    std::vector<BsdfCase> cases;
    std::vector<BsdfQuery> draws, queries;
    for (const float roughness : {0.0f, 0.0099f, 0.01f, 0.02f, 0.1f, 0.5f, 1.0f})
        for (const float eta : {0.0f, 1 / 1.5f, 1 - 1e-6f, 1.0f, 1 + 1e-6f, 1.001f, 1.5f, 2.4f})
            for (const float mix : {0.0f, 0.5f, 1.0f}) {
                const auto which = static_cast<uint32_t>(cases.size());
                cases.push_back({.parameters = {.metallic = 0.3f * mix,
                                                .roughness = roughness,
                                                .transmission = mix,
                                                .solid = true,
                                                .eta = eta}});
                for (const float cosine : {1e-6f, 1e-3f, 0.5f, 1.0f})
                    for (int i = 0; i < 50; ++i) {
                        const vec3 wo(0, std::sqrt(1 - cosine * cosine), cosine);
                        const float u_lobe = random.next();
                        draws.push_back({which, wo, vec3(u_lobe, random.next_2d())});
                        queries.push_back({which, wo, cosine_direction(random) * (i % 2 ? 1.0f : -1.0f)});
                    }
            }
    for (const BsdfSample& s : bsdfs.sample(cases, draws)) {
        ASSERT_TRUE(is_finite(s.weight) && std::isfinite(s.pdf_sa) && s.pdf_sa >= 0);
        ASSERT_TRUE(s.weight.x >= 0 && s.weight.y >= 0 && s.weight.z >= 0);
    }
    for (const BsdfValue& value : bsdfs.evaluate(cases, queries)) {
        ASSERT_TRUE(is_finite(value.f_cos) && std::isfinite(value.pdf_sa) && value.pdf_sa >= 0);
        ASSERT_TRUE(value.f_cos.x >= 0 && value.f_cos.y >= 0 && value.f_cos.z >= 0);
    }
}

}  // namespace photond::test
