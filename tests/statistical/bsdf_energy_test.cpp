// No material scatters more than it gets, at any roughness and angle; a GGX lobe alone scatters what an independent
// quadrature of the textbook formula says.

#include <gtest/gtest.h>

#include "renderer/core/rng.h"
#include "renderer/transport/bsdf_albedo_table.h"
#include "renderer/transport/fresnel.h"
#include "tests/support/bsdf_quadrature.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

using namespace test;

constexpr float kRoughnesses[] = {0.0f, 0.005f, 0.01f, 0.013f, 0.03f, 0.1f, 0.2f, 0.35f, 0.5f, 0.75f, 1.0f};
constexpr double kCosines[] = {1, 0.9, 0.6, 0.3, 0.1, 0.03, 0.003};
/// Of the midpoint rule over cut lobes; lobes narrower than 1e-3 are also evaluated at half-vectors of rounded
/// directions.
double quadrature_error(float roughness) { return roughness > 0.02f ? 5e-4 : 1.5e-3; }

/// What the delta lobes scatter: their weights times probabilities, one draw in each stratum of the lobe's number.
dvec3 delta_albedo(const Bsdf& bsdf, const vec3& wo) {
    constexpr int kStrata = 4096;
    dvec3 sum(0);
    for (int i = 0; i < kStrata; ++i) {
        const BsdfSample s =
            bsdf.sample(wo, (static_cast<float>(i) + 0.5f) / kStrata, vec2(0.5f), TransportMode::Importance);
        if (s.valid() && s.delta) sum += dvec3(s.weight) / double(kStrata);
    }
    return sum;
}

dvec3 directional_albedo(const Bsdf::Parameters& p, double cos_theta) {
    const Bsdf bsdf = Bsdf::layered(p);
    const dvec3 wo = direction_at(std::min(cos_theta, 0.99999), 0.1);
    // A coat that is a mirror leaves the diffuse lobe, smooth in the coordinates of a wide one.
    const double alpha = p.roughness < kDeltaRoughness ? 1.0 : sqr(p.roughness);
    const ScatteringMap map{HalfVectorMap(alpha), wo, static_cast<double>(p.eta)};
    const CellGrid grid{3, 1, 160};
    dvec3 sum = delta_albedo(bsdf, vec3(wo));
    if (!bsdf.has_non_delta()) return sum;
    sum += integrate_bsdf(bsdf, map, Side::Reflected, grid).f_cos;
    if (bsdf.has_non_delta_transmission())
        sum += integrate_bsdf(bsdf, map, p.solid ? Side::Refracted : Side::Mirrored, grid).f_cos;
    return sum;
}

// White materials of every kind in a white furnace. The strata of the delta lobes add an error of 1/4096 of each
// weight.
TEST(BsdfEnergy, NothingScattersMoreThanItGets) {
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
        for (const float roughness : kRoughnesses)
            for (const double cos_theta : kCosines) {
                Bsdf::Parameters p = c.p;
                p.roughness = roughness;
                const dvec3 albedo = directional_albedo(p, cos_theta);
                for (int i = 0; i < 3; ++i) {
                    greatest = std::max(greatest, albedo[i]);
                    EXPECT_LE(albedo[i], 1 + quadrature_error(roughness))
                        << c.name << ", roughness " << roughness << ", cos " << cos_theta << ", channel " << i;
                    EXPECT_GE(albedo[i], 0.2) << c.name << ", roughness " << roughness << ", cos " << cos_theta;
                }
            }
    EXPECT_GT(greatest, 0.995);  // smooth white materials lose nothing: the bound is tight
}

TEST(BsdfEnergy, MirrorsAndClearGlassLoseNothing) {
    for (const double cos_theta : kCosines) {
        for (const Bsdf::Parameters& p :
             {Bsdf::Parameters{.metallic = 1, .roughness = 0}, Bsdf::Parameters{.roughness = 0, .transmission = 1},
              Bsdf::Parameters{.roughness = 0, .transmission = 1, .solid = true},
              Bsdf::Parameters{.roughness = 0, .transmission = 1, .solid = true, .eta = 0.6f}})
            EXPECT_NEAR(directional_albedo(p, cos_theta).y, 1, 1.0 / 4096) << cos_theta;
        // Delta lobes weigh exactly their reflectance over their probability, sample by sample.
        const Bsdf mirror = Bsdf::layered({.base_color = Rgb(0.9f, 0.5f, 0.1f), .metallic = 1, .roughness = 0});
        const vec3 wo(direction_at(std::min(cos_theta, 0.99999), 0.3));
        const BsdfSample s = mirror.sample(wo, 0.3f, vec2(0.1f, 0.9f));
        ASSERT_TRUE(s.valid() && s.delta && !s.transmission);
        EXPECT_NEAR(glm::distance(s.wi, vec3(-wo.x, -wo.y, wo.z)), 0, 1e-6);
        const float expected = 0.1f + 0.9f * std::pow(1 - wo.z, 5.0f);
        EXPECT_NEAR(s.weight.z, expected, 1e-5);
    }
}

/// GGX with Schlick's Fresnel as the textbooks write it, in double, over half-vectors by slope.
double textbook_albedo(double alpha, double f0, double f90, double cos_theta) {
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

TEST(BsdfEnergy, OneBounceOfGgxIsItsDirectionalAlbedo) {
    constexpr double kFalseAlarm = 1e-6;
    constexpr int kDraws = 200'000;
    const double z = two_sided_z(share_of_false_alarm(kFalseAlarm, std::size(kRoughnesses) * std::size(kCosines)));
    uint64_t stream = 0;
    for (const float roughness : kRoughnesses) {
        if (roughness < kDeltaRoughness) continue;
        for (const double cos_theta : kCosines) {
            const double cosine = std::min(cos_theta, 0.99999), f0 = 0.6;
            const double exact = textbook_albedo(sqr(roughness), f0, 1, cosine);
            const Bsdf metal = Bsdf::layered({.base_color = Rgb(0.6f), .metallic = 1, .roughness = roughness});
            RandomStream random(3, RandomDomain::Test, 0, ++stream);
            RunningMean mean;
            const vec3 wo(direction_at(cosine, 0.7));
            for (int i = 0; i < kDraws; ++i) {
                const BsdfSample s = metal.sample(wo, 0.5f, random.next_2d());
                mean.add(s.valid() ? s.weight.x : 0);
            }
            const double tolerance = z * mean.standard_error() + 5e-4;
            EXPECT_NEAR(mean.mean(), exact, tolerance) << "roughness " << roughness << ", cos " << cos_theta;
            EXPECT_LE(tolerance, 0.01);
        }
    }
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
}  // namespace photond
