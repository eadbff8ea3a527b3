#pragma once
// That BSDFs scatter no more than they get, checked of whoever answers (bsdf_case.h): the C++ and its GLSL twin by the
// same code.

#include <gtest/gtest.h>

#include "tests/support/bsdf_case.h"
#include "tests/support/statistics.h"

namespace photond::test {

/// Of the midpoint rule over cut lobes; lobes narrower than 1e-3 are also evaluated at half-vectors of rounded
/// directions.
inline double quadrature_error(float roughness) { return roughness > 0.02f ? 5e-4 : 1.5e-3; }

/// What the delta lobes scatter: their weights times probabilities, one draw in each stratum of the lobe's number.
template <class Bsdfs>
dvec3 delta_albedo(const Bsdfs& bsdfs, const Bsdf::Parameters& parameters, const vec3& wo) {
    constexpr size_t kStrata = 4096;
    const BsdfCase importance{.parameters = parameters, .mode = TransportMode::Importance};
    std::vector<BsdfQuery> queries;
    for (size_t i = 0; i < kStrata; ++i)
        queries.push_back({0, wo, vec3((static_cast<float>(i) + 0.5f) / kStrata, 0.5f, 0.5f)});
    dvec3 sum(0);
    for (const BsdfSample& s : bsdfs.sample(std::span(&importance, 1), queries))
        if (s.valid() && s.delta) sum += dvec3(s.weight) / double(kStrata);
    return sum;
}

template <class Bsdfs>
dvec3 directional_albedo(const Bsdfs& bsdfs, const Bsdf::Parameters& p, double cos_theta) {
    const Bsdf bsdf = Bsdf::layered(p);
    const dvec3 wo = direction_at(std::min(cos_theta, 0.99999), 0.1);
    // A coat that is a mirror leaves the diffuse lobe, smooth in the coordinates of a wide one.
    const double alpha = p.roughness < DELTA_ROUGHNESS ? 1.0 : sqr(p.roughness);
    const ScatteringMap map{HalfVectorMap(alpha), wo, static_cast<double>(p.eta)};
    const CellGrid grid{3, 1, 160};
    dvec3 sum(0);
    if (bsdf.has_delta()) sum += delta_albedo(bsdfs, p, vec3(wo));
    if (!bsdf.has_non_delta()) return sum;
    sum += integrate_case(bsdfs, p, map, Side::Reflected, grid).f_cos;
    if (bsdf.has_non_delta_transmission())
        sum += integrate_case(bsdfs, p, map, p.solid ? Side::Refracted : Side::Mirrored, grid).f_cos;
    return sum;
}

/// White materials of every kind in a white furnace. The strata of the delta lobes add an error of 1/4096 of each
/// weight.
template <class Bsdfs>
void expect_nothing_scatters_more_than_it_gets(const Bsdfs& bsdfs, const std::vector<float>& roughnesses,
                                               const std::vector<double>& cosines) {
    struct Case {
        const char* name;
        Bsdf::Parameters p;
    };
    std::vector<Case> cases(8);
    cases[0] = {"coated diffuse", {}};
    cases[1] = {"diamond-coated diffuse", {.ior = 2.4f}};
    cases[2] = {"coloured strong coat", {.ior = 2.4f, .specular_color = Rgb(6, 1, 0.2f)}};
    cases[3] = {"half metal", {.metallic = 0.5f}};
    cases[4] = {"half thin sheet", {.transmission = 0.5f}};
    cases[5] = {"thin sheet", {.transmission = 1}};
    cases[6] = {"half glass", {.transmission = 0.5f, .solid = true}};
    cases[7] = {"glass from inside", {.transmission = 1, .solid = true, .eta = 1 / 1.5f}};
    double greatest = 0;
    for (const Case& c : cases)
        for (const float roughness : roughnesses)
            for (const double cos_theta : cosines) {
                Bsdf::Parameters p = c.p;
                p.roughness = roughness;
                const dvec3 albedo = directional_albedo(bsdfs, p, cos_theta);
                for (int i = 0; i < 3; ++i) {
                    greatest = std::max(greatest, albedo[i]);
                    EXPECT_LE(albedo[i], 1 + quadrature_error(roughness))
                        << c.name << ", roughness " << roughness << ", cos " << cos_theta << ", channel " << i;
                }
                // Of a coat that reflects all red nothing passes of other colours either.
                EXPECT_GE(std::max({albedo.x, albedo.y, albedo.z}), 0.2)
                    << c.name << ", roughness " << roughness << ", cos " << cos_theta;
            }
    EXPECT_GT(greatest, 0.995);  // smooth white materials lose nothing: the bound is tight
}

template <class Bsdfs>
void expect_mirrors_and_clear_glass_lose_nothing(const Bsdfs& bsdfs, const std::vector<double>& cosines) {
    for (const double cos_theta : cosines) {
        for (const Bsdf::Parameters& p :
             {Bsdf::Parameters{.metallic = 1, .roughness = 0}, Bsdf::Parameters{.roughness = 0, .transmission = 1},
              Bsdf::Parameters{.roughness = 0, .transmission = 1, .solid = true},
              Bsdf::Parameters{.roughness = 0, .transmission = 1, .solid = true, .eta = 0.6f}})
            EXPECT_NEAR(directional_albedo(bsdfs, p, cos_theta).y, 1, 1.0 / 4096) << cos_theta;
        // Delta lobes weigh exactly their reflectance over their probability, sample by sample.
        const BsdfCase mirror{.parameters = {.base_color = Rgb(0.9f, 0.5f, 0.1f), .metallic = 1, .roughness = 0}};
        const vec3 wo(direction_at(std::min(cos_theta, 0.99999), 0.3));
        const BsdfQuery query{0, wo, vec3(0.3f, 0.1f, 0.9f)};
        const BsdfSample s = bsdfs.sample(std::span(&mirror, 1), std::span(&query, 1))[0];
        ASSERT_TRUE(s.valid() && s.delta && !s.transmission);
        EXPECT_NEAR(glm::distance(s.wi, vec3(-wo.x, -wo.y, wo.z)), 0, 1e-6);
        const float expected = 0.1f + 0.9f * std::pow(1 - wo.z, 5.0f);
        EXPECT_NEAR(s.weight.z, expected, 1e-5);
    }
}

/// GGX with Schlick's Fresnel as the textbooks write it, in double, over half-vectors by slope.
inline double textbook_albedo(double alpha, double f0, double f90, double cos_theta) {
    const dvec3 wo = direction_at(cos_theta, 0.0);
    const auto lambda = [&](double c) { return 0.5 * (std::sqrt(1 + alpha * alpha * (1 / (c * c) - 1)) - 1); };
    constexpr int kRadial = 500, kAzimuths = 120;
    double sum = 0;
    for (int i = 0; i < kRadial; ++i) {
        // Cumulative distribution of D cos: r = s^2 / (1 + s^2); spaced as a cube towards the tail.
        const double v = (i + 0.5) / kRadial, rest = v * v * v, s2 = 1 / rest - 1;
        const double cos_h = 1 / std::sqrt(1 + alpha * alpha * s2), sin_h = std::sqrt(1 - cos_h * cos_h);
        for (int j = 0; j < kAzimuths; ++j) {
            const double phi = M_PI * (j + 0.5) / kAzimuths;
            const dvec3 h(sin_h * std::cos(phi), sin_h * std::sin(phi), cos_h);
            const double cos_d = glm::dot(wo, h);
            const dvec3 wi = 2 * cos_d * h - wo;
            if (cos_d <= 0 || wi.z <= 0) continue;
            const double fresnel = f0 + (f90 - f0) * std::pow(1 - cos_d, 5);
            const double g2 = 1 / (1 + lambda(wo.z) + lambda(wi.z));
            // D cos_h dh has unit mass: f cos dwi = F G2 cos_d / (cos_o cos_h) of it.
            sum += 3 * v * v * fresnel * g2 * cos_d / (wo.z * cos_h);
        }
    }
    return sum / kRadial / kAzimuths;
}

/// One bounce of GGX scatters what an independent quadrature of the textbook formula says.
template <class Bsdfs>
void expect_one_bounce_of_ggx_is_its_albedo(const Bsdfs& bsdfs, double false_alarm, size_t draws,
                                            const std::vector<float>& roughnesses, const std::vector<double>& cosines) {
    const double z = two_sided_z(share_of_false_alarm(false_alarm, roughnesses.size() * cosines.size()));
    uint64_t stream = 0;
    for (const float roughness : roughnesses) {
        if (roughness < DELTA_ROUGHNESS) continue;
        for (const double cos_theta : cosines) {
            const double cosine = std::min(cos_theta, 0.99999), f0 = 0.6;
            const double exact = textbook_albedo(sqr(roughness), f0, 1, cosine);
            const Bsdf::Parameters metal{.base_color = Rgb(0.6f), .metallic = 1, .roughness = roughness};
            RunningMean mean;
            const vec3 wo(direction_at(cosine, 0.7));
            for (const BsdfSample& s :
                 sample_case(bsdfs, metal, wo, RandomStream(3, RandomDomain::Test, 0, ++stream), draws))
                mean.add(s.valid() ? s.weight.x : 0);
            const double tolerance = z * mean.standard_error() + 5e-4;
            EXPECT_NEAR(mean.mean(), exact, tolerance) << "roughness " << roughness << ", cos " << cos_theta;
            EXPECT_LE(tolerance, 0.01);
        }
    }
}

}  // namespace photond::test
