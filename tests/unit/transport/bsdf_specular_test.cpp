// KHR_materials_specular: what lies under a reflection that has a colour is weighed by 1 - its greatest channel, so
// that the base keeps its own colour instead of taking on the complement.

#include <gtest/gtest.h>

#include "tests/support/bsdf_energy_checks.h"

namespace photond::bsdf_specular_test {
namespace {

using namespace test;

const Rgb kColors[] = {Rgb(1), Rgb(1, 0.3f, 0), Rgb(0.2f, 2.5f, 1)};
const double kCosines[] = {0.95, 0.6, 0.2, 0.05};

/// Schlick's Fresnel of the extension's text, a channel.
double schlick_of(const Bsdf::Parameters& p, int channel, double cos_theta) {
    const double f0 =
        std::min(std::pow((1 - double{p.ior}) / (1 + double{p.ior}), 2) * double{p.specular_color[channel]}, 1.0);
    return double{p.specular} * (f0 + (1 - f0) * std::pow(1 - cos_theta, 5));
}

double greatest_schlick(const Bsdf::Parameters& p, double cos_theta) {
    double greatest = 0;
    for (int c = 0; c < 3; ++c) greatest = std::max(greatest, schlick_of(p, c, cos_theta));
    return greatest;
}

/// Of uniform light; a lobe that does not depend on the azimuth.
dvec3 reflected_of(const Bsdf& base, const vec3& wo) {
    constexpr int kSteps = 400;
    dvec3 reflected(0);
    for (int i = 0; i < kSteps; ++i) {
        const vec3 wi(direction_at(std::sqrt((i + 0.5) / kSteps), 0.7));
        reflected += dvec3(base.f_cos(wo, wi)) * M_PI / double{wi.z} / double{kSteps};
    }
    return reflected;
}

TEST(BsdfSpecular, ABaseHasWhatTheGreatestChannelLeaves) {
    for (const Rgb& color : kColors)
        for (const float ior : {1.5f, 2.2f})
            for (const float roughness : {0.0f, 0.3f, 1.0f})
                for (const double cos_theta : kCosines) {
                    const Bsdf::Parameters p{.base_color = Rgb(0.9f, 0.6f, 0.3f),
                                             .roughness = roughness,
                                             .ior = ior,
                                             .specular = 0.8f,
                                             .specular_color = color};
                    const Bsdf base = Bsdf::layered(p).rough_part(2);  // the diffuse lobe alone
                    const vec3 wo(direction_at(cos_theta, 0.1));
                    const dvec3 reflected = reflected_of(base, wo);
                    EXPECT_NEAR(reflected.y / reflected.x, 0.6 / 0.9, 1e-5);
                    EXPECT_NEAR(reflected.z / reflected.x, 0.3 / 0.9, 1e-5);
                    const double coat = roughness == 0 ? greatest_schlick(p, cos_theta)
                                                       : textbook_albedo(double{sqr(roughness)}, greatest_schlick(p, 1),
                                                                         double{p.specular}, cos_theta);
                    // The table of albedos lies above the truth, by up to a hundredth.
                    const double share = reflected.x / 0.9;
                    EXPECT_LE(share, 1 - coat + 2e-4) << "cos " << cos_theta << ", roughness " << roughness;
                    EXPECT_GE(share, 1 - coat - (roughness == 0 ? 2e-4 : 0.01)) << "cos " << cos_theta;
                }
}

/// Of uniform light, by glTF's sample formula: the base weighs 1 - F at the half-vector.
double base_of_sample_formula(double f0, double cos_theta) {
    constexpr int kRadial = 300, kAzimuths = 100;
    const dvec3 wo = direction_at(cos_theta, 0.0);
    double sum = 0;
    for (int i = 0; i < kRadial; ++i)
        for (int j = 0; j < kAzimuths; ++j) {
            const dvec3 wi = direction_at(std::sqrt((i + 0.5) / kRadial), 0.5 * (j + 0.5) / kAzimuths);
            sum += 1 - f0 - (1 - f0) * std::pow(1 - glm::dot(wo, glm::normalize(wo + wi)), 5);
        }
    return sum / kRadial / kAzimuths;
}

// The table of conventions.md, "Materials": what departs from the formula, and by how much.
TEST(BsdfSpecular, DepartsFromTheSampleFormulaAsTheManualSays) {
    struct Row {
        float roughness;
        double degrees, base, here, formula;
    };
    const Row rows[] = {{0.1f, 0, 0.8, 0.807, 0.808},  {0.1f, 45, 0.8, 0.808, 0.809}, {0.1f, 60, 0.8, 0.813, 0.834},
                        {0.1f, 75, 0.8, 0.850, 1.012}, {0.1f, 85, 0.8, 0.925, 1.384}, {0.5f, 0, 0.8, 0.807, 0.805},
                        {0.5f, 45, 0.8, 0.807, 0.806}, {0.5f, 60, 0.8, 0.811, 0.820}, {0.5f, 75, 0.8, 0.821, 0.867},
                        {0.5f, 85, 0.8, 0.834, 0.927}, {1.0f, 0, 0.8, 0.802, 0.780},  {1.0f, 45, 0.8, 0.803, 0.783},
                        {1.0f, 60, 0.8, 0.804, 0.785}, {1.0f, 75, 0.8, 0.806, 0.792}, {1.0f, 85, 0.8, 0.811, 0.807},
                        {0.1f, 75, 1.0, 0.999, 1.202}, {0.1f, 75, 0.2, 0.403, 0.443}};
    for (const Row& row : rows) {
        const double cos_theta = std::min(std::cos(row.degrees * M_PI / 180), 0.99999);
        const double specular = textbook_albedo(double{sqr(row.roughness)}, 0.04, 1, cos_theta);
        const Bsdf base =
            Bsdf::layered({.base_color = Rgb(static_cast<float>(row.base)), .roughness = row.roughness}).rough_part(2);
        EXPECT_NEAR(reflected_of(base, vec3(direction_at(cos_theta, 0.1))).x + specular, row.here, 1e-3) << row.degrees;
        EXPECT_NEAR(row.base * base_of_sample_formula(0.04, cos_theta) + specular, row.formula, 1e-3) << row.degrees;
    }
}

/// What is reflected and what passes of a surface whose lobes are delta.
struct DeltaShares {
    dvec3 reflected{0}, passed{0};
};
DeltaShares delta_shares(const Bsdf::Parameters& p, const vec3& wo) {
    DeltaShares shares;
    const Bsdf bsdf = Bsdf::layered(p);
    for (const float u_lobe : {0.0f, 0.999999f}) {
        const BsdfSample s = bsdf.sample(wo, u_lobe, vec2(0.5f), TransportMode::Importance);
        EXPECT_TRUE(s.delta && s.valid() && s.transmission == (u_lobe > 0));
        (s.transmission ? shares.passed : shares.reflected) = dvec3(s.weight) * double{s.pdf_sa};
    }
    return shares;
}

TEST(BsdfSpecular, AThinSheetHasWhatTheGreatestChannelLeaves) {
    for (const Rgb& color : kColors)
        for (const double cos_theta : kCosines) {
            Bsdf::Parameters p{.base_color = Rgb(0.9f, 0.6f, 0.3f),
                               .roughness = 0,
                               .specular = 0.7f,
                               .specular_color = color,
                               .transmission = 1};
            const vec3 wo(direction_at(cos_theta, 0.1));
            const DeltaShares smooth = delta_shares(p, wo);
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(smooth.reflected[c], schlick_of(p, c, double{wo.z}), 1e-5);
                EXPECT_NEAR(smooth.passed[c], (1 - greatest_schlick(p, double{wo.z})) * double{p.base_color[c]}, 1e-5);
            }
            p.roughness = 0.4f;
            const Bsdf rough = Bsdf::layered(p);
            const Rgb reflected = rough.f_cos(wo, {-wo.x, -wo.y, wo.z}), passed = rough.f_cos(wo, -wo);
            for (int c = 0; c < 3; ++c)  // both of facets that lie flat
                EXPECT_NEAR(double{passed[c]} / double{max_component(reflected)},
                            double{p.base_color[c]} * (1 / greatest_schlick(p, double{wo.z}) - 1),
                            1e-4 / greatest_schlick(p, double{wo.z}));
        }
}

TEST(BsdfSpecular, ASolidHasWhatTheGreatestChannelLeaves) {
    for (const Rgb& color : {Rgb(1), Rgb(1, 0.3f, 0), Rgb(0.2f, 30, 1)})  // the last reflects all green that it may
        for (const double cos_theta : kCosines) {
            const Bsdf::Parameters p{.base_color = Rgb(0.9f, 0.6f, 0.3f),
                                     .roughness = 0,
                                     .specular = 0.7f,
                                     .specular_color = color,
                                     .transmission = 1,
                                     .solid = true,
                                     .eta = 1.5f};
            const vec3 wo(direction_at(cos_theta, 0.1));
            const double cos_o = double{wo.z}, cos_t = std::sqrt(1 - (1 - cos_o * cos_o) / 2.25);
            const double s = (cos_o - 1.5 * cos_t) / (cos_o + 1.5 * cos_t),
                         t = (1.5 * cos_o - cos_t) / (1.5 * cos_o + cos_t);
            const double fresnel = 0.5 * (s * s + t * t), grazing = std::pow(1 - std::min(cos_o, cos_t), 5);
            dvec3 reflected;
            for (int c = 0; c < 3; ++c) {
                const double tint = double{color[c]} + (1 - double{color[c]}) * grazing;
                reflected[c] = 0.7 * std::min(fresnel * tint, 1.0);
            }
            const DeltaShares shares = delta_shares(p, wo);
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(shares.reflected[c], reflected[c], 1e-5) << cos_theta;
                EXPECT_NEAR(shares.passed[c],
                            (1 - std::max({reflected.x, reflected.y, reflected.z})) * double{p.base_color[c]}, 1e-5)
                    << cos_theta;
            }
        }
}

}  // namespace
}  // namespace photond::bsdf_specular_test
