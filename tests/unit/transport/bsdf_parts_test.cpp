// A BSDF is the sum of its specular and its rough part; each is sampled by itself, with the density it states.

#include <gtest/gtest.h>

#include "renderer/core/rng.h"
#include "tests/support/random_materials.h"
#include "tests/support/statistics.h"

namespace photond::bsdf_parts_test {
namespace {

using namespace test;

constexpr double kFalseAlarm = 1e-6;
constexpr float kThreshold = 0.05f;  // alpha

TEST(BsdfParts, AddUpToTheWhole) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    int specular_light = 0, rough_light = 0, transmitted = 0;
    for (int i = 0; i < 20'000; ++i) {
        const Bsdf::Parameters p = random_material(random);
        const Bsdf bsdf = Bsdf::layered(p);
        const float threshold = i % 4 ? random.next() : 0.0f;
        const Bsdf specular = bsdf.specular_part(threshold), rough = bsdf.rough_part(threshold);
        const vec3 wo = random_direction(random, 0);
        // Near the mirrored direction as often as anywhere, where narrow lobes are.
        vec3 wi = random_direction(random, -1);
        if (i % 2) wi = glm::normalize(vec3(-wo.x, -wo.y, std::copysign(wo.z, wi.z)) + 0.1f * wi);
        for (const TransportMode mode : {TransportMode::Radiance, TransportMode::Importance}) {
            const Rgb whole = bsdf.f_cos(wo, wi, mode), s = specular.f_cos(wo, wi, mode), r = rough.f_cos(wo, wi, mode);
            for (int c = 0; c < 3; ++c) ASSERT_NEAR(s[c] + r[c], whole[c], 1e-6f * whole[c]) << i;
            // What is scattered can be found by sampling.
            ASSERT_TRUE(is_black(s) || specular.pdf_sa(wo, wi) > 0) << i;
            ASSERT_TRUE(is_black(r) || rough.pdf_sa(wo, wi) > 0) << i;
            specular_light += !is_black(s), rough_light += !is_black(r);
            transmitted += wi.z < 0 && !is_black(whole);
        }
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(specular.albedo()[c] + rough.albedo()[c], bsdf.albedo()[c], 1e-5f) << i;
    }
    EXPECT_GT(specular_light, 3000);
    EXPECT_GT(rough_light, 3000);
    EXPECT_GT(transmitted, 1000);
}

TEST(BsdfParts, LobesAreSpecularBelowTheThresholdAndWhenDelta) {
    const float roughness = 0.3f, alpha = sqr(roughness);
    const float above = std::nextafter(alpha, 1.0f);
    std::vector<Bsdf::Parameters> lobes(3);  // one lobe each
    lobes[0] = {.metallic = 1};
    lobes[1] = {.transmission = 1};
    lobes[2] = {.transmission = 1, .solid = true};
    for (Bsdf::Parameters& p : lobes) {
        p.roughness = roughness;
        const Bsdf rough = Bsdf::layered(p);
        EXPECT_FALSE(rough.specular_part(alpha).scatters());
        EXPECT_TRUE(rough.rough_part(alpha).scatters());
        EXPECT_TRUE(rough.specular_part(above).scatters());
        EXPECT_FALSE(rough.rough_part(above).scatters());
        EXPECT_EQ(rough.rough_part(alpha).has_non_delta_transmission(), rough.has_non_delta_transmission());
        p.roughness = 0;
        const Bsdf delta = Bsdf::layered(p);
        EXPECT_TRUE(delta.specular_part(0).scatters() && delta.specular_part(0).has_delta());
        EXPECT_FALSE(delta.rough_part(0).scatters());
    }
    const Bsdf coated = Bsdf::layered({.roughness = roughness});
    EXPECT_TRUE(coated.specular_part(above).scatters());
    EXPECT_FALSE(coated.specular_part(above).is_diffuse());
    EXPECT_TRUE(coated.rough_part(above).is_diffuse());
    EXPECT_FALSE(coated.is_diffuse() || coated.rough_part(alpha).is_diffuse());
    // Rough glass that hardly refracts is delta, its coat on the opaque share is not.
    const Bsdf mixed = Bsdf::layered({.roughness = roughness, .transmission = 0.5f, .solid = true, .eta = 1});
    EXPECT_TRUE(mixed.specular_part(alpha).has_delta());
    EXPECT_FALSE(mixed.specular_part(alpha).has_non_delta());
    EXPECT_TRUE(mixed.rough_part(alpha).has_non_delta());
    EXPECT_FALSE(mixed.rough_part(alpha).has_delta());
}

TEST(BsdfParts, LambertIsRoughAndNothingIsNothing) {
    const Bsdf lambert = Bsdf::lambert(vec3(0, 0, 1), Rgb(0.5f));
    EXPECT_TRUE(lambert.scatters() && lambert.is_diffuse());
    EXPECT_FALSE(lambert.specular_part(1).scatters());
    EXPECT_TRUE(lambert.rough_part(1).is_lambert());
    const vec3 w(0.6f, 0, 0.8f);
    EXPECT_EQ(lambert.rough_part(1).f_cos(w, w), lambert.f_cos(w, w));
    EXPECT_FALSE(Bsdf::lambert(vec3(0, 0, 1), Rgb(0)).scatters());
    EXPECT_FALSE(Bsdf().scatters() || Bsdf().is_diffuse());
    EXPECT_FALSE(Bsdf().specular_part(1).scatters() || Bsdf().rough_part(1).scatters());
}

TEST(BsdfParts, DeltaPartsAreDrawnWithProbabilityOne) {
    RandomStream random(2, RandomDomain::Test, 0, 0);
    const vec3 wo(direction_at(0.6, 0.1));
    const Bsdf coat = Bsdf::layered({.base_color = Rgb(0.7f), .roughness = 0}).specular_part(kThreshold);
    const float fresnel = 0.04f + 0.96f * std::pow(0.4f, 5.0f);
    for (int i = 0; i < 1000; ++i) {
        const float u_lobe = random.next();
        const BsdfSample s = coat.sample(wo, u_lobe, random.next_2d());
        ASSERT_TRUE(s.valid() && s.delta);
        ASSERT_FLOAT_EQ(s.pdf_sa, 1);
        ASSERT_NEAR(s.weight.x, fresnel, 1e-6f);
    }
    const Bsdf base = Bsdf::layered({.base_color = Rgb(0.7f), .roughness = 0}).rough_part(kThreshold);
    for (int i = 0; i < 1000; ++i) {
        const float u_lobe = random.next();
        const BsdfSample s = base.sample(wo, u_lobe, random.next_2d());
        ASSERT_FALSE(s.delta);
        if (!s.valid()) continue;
        ASSERT_FLOAT_EQ(s.pdf_sa, s.wi.z * kInvPi);
    }
}

// Chi-square over the cells of half-vectors, and the mean weight against the integral of f |cos|.
TEST(BsdfParts, AreDrawnWithTheDensitiesTheyState) {
    constexpr int kDraws = 60'000;
    constexpr CellGrid kGrid{12, 6, 28};
    std::vector<Bsdf::Parameters> materials(4, {.base_color = Rgb(0.8f, 0.5f, 0.2f)});
    materials[1].metallic = 0.4f, materials[1].geometric_normal = vec3(direction_at(0.85, 0.3));
    materials[2].transmission = 0.5f;
    materials[3].transmission = 0.5f, materials[3].solid = true;
    const float roughnesses[] = {0.15f, 0.5f};  // alpha on either side of the threshold
    const double cosines[] = {0.9, 0.3};
    const size_t checks = materials.size() * 2 * 2 * 2 * 4;
    const double share = share_of_false_alarm(kFalseAlarm, checks);
    uint64_t stream = 0;
    for (Bsdf::Parameters& p : materials)
        for (const float roughness : roughnesses)
            for (const double cos_theta : cosines) {
                p.roughness = roughness;
                const Bsdf bsdf = Bsdf::layered(p);
                for (const Bsdf& part : {bsdf.specular_part(kThreshold), bsdf.rough_part(kThreshold)}) {
                    SCOPED_TRACE(testing::Message() << &p - materials.data() << ", roughness " << roughness << ", cos "
                                                    << cos_theta << ", part " << stream % 2);
                    RandomStream random(3, RandomDomain::Test, 0, ++stream);
                    if (!part.scatters()) continue;
                    const ScatteringMap map{HalfVectorMap(sqr(roughness)), direction_at(cos_theta, 0.1),
                                            static_cast<double>(p.eta)};
                    const Side far_side = p.solid ? Side::Refracted : Side::Mirrored;
                    const CellIntegrals near = integrate_bsdf(part, map, Side::Reflected, kGrid);
                    const CellIntegrals far = integrate_bsdf(part, map, far_side, kGrid);

                    std::vector<double> observed(2 * kGrid.cells() + 1, 0), expected = near.pdf;
                    expected.insert(expected.end(), far.pdf.begin(), far.pdf.end());
                    const double lost = 1 - near.total_pdf() - far.total_pdf();
                    RunningMean weight[3];
                    for (int i = 0; i < kDraws; ++i) {
                        const float u_lobe = random.next();
                        const BsdfSample s =
                            part.sample(vec3(map.wo), u_lobe, random.next_2d(), TransportMode::Importance);
                        for (int c = 0; c < 3; ++c) weight[c].add(s.valid() ? s.weight[c] : 0);
                        if (!s.valid()) {
                            ++observed.back();
                            continue;
                        }
                        const Side side = s.transmission ? far_side : Side::Reflected;
                        ++observed[kGrid.cell(map.half_vectors, map.half_vector(side, dvec3(s.wi))) +
                                   (s.transmission ? kGrid.cells() : 0)];
                    }
                    EXPECT_GT(lost, -2e-3);
                    // Losses smaller than the quadrature's error are not asked for.
                    if (lost > 1e-3)
                        expected.push_back(lost);
                    else
                        observed.pop_back();
                    for (double& x : expected) x = std::max(x * kDraws, 1e-3);
                    EXPECT_GT(chi_square_probability(observed, expected), share);
                    for (int c = 0; c < 3; ++c)
                        EXPECT_NEAR(weight[c].mean(), near.f_cos[c] + far.f_cos[c],
                                    two_sided_z(share) * weight[c].standard_error() + 1e-3);
                }
            }
}

}  // namespace
}  // namespace photond::bsdf_parts_test
