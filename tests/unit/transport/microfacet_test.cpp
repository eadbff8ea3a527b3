// Identities of Fresnel, refraction and the GGX distribution, and reciprocity of whole BSDFs.

#include "renderer/transport/microfacet.h"

#include <gtest/gtest.h>

#include "renderer/core/rng.h"
#include "renderer/transport/bsdf.h"
#include "renderer/transport/fresnel.h"
#include "tests/support/bsdf_reciprocity_checks.h"

namespace photond::microfacet_test {
namespace {

using namespace test;

TEST(Fresnel, KnownAngles) {
    EXPECT_FLOAT_EQ(fresnel_dielectric(1.0f, 1.5f).reflectance, 0.04f);
    EXPECT_FLOAT_EQ(normal_reflectance(1.5f), 0.04f);
    EXPECT_NEAR(fresnel_dielectric(1e-4f, 1.5f).reflectance, 1, 1e-3);
    EXPECT_EQ(fresnel_dielectric(0.3f, 1.0f).reflectance, 0);  // no interface
    EXPECT_EQ(fresnel_dielectric(1.0f, 0.0f).reflectance, 1);
    // Brewster's angle, tan = eta: only the perpendicular part is left, ((eta^2 - 1) / (eta^2 + 1))^2 / 2.
    const float brewster = std::cos(std::atan(1.5f));
    EXPECT_NEAR(fresnel_dielectric(brewster, 1.5f).reflectance, 0.5f * sqr(1.25f / 3.25f), 1e-6);
    // Total reflection begins at sin = eta.
    const float critical = std::sqrt(1 - 1 / sqr(1.5f));
    EXPECT_EQ(fresnel_dielectric(critical - 1e-3f, 1 / 1.5f).reflectance, 1);
    EXPECT_LT(fresnel_dielectric(critical + 1e-3f, 1 / 1.5f).reflectance, 1);
}

TEST(Fresnel, BothSidesAgreeAndRefractionRunsBack) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 2000; ++i) {
        const float eta = 1.0f + 1.5f * random.next();
        const vec3 wo = cosine_direction(random), h(0, 0, 1);
        const DielectricFresnel in = fresnel_dielectric(wo.z, eta);
        ASSERT_GT(in.cos_t, 0);
        const vec3 wi = refract_direction(wo, h, wo.z, in.cos_t, eta);
        ASSERT_NEAR(glm::length(wi), 1, 2e-6);
        ASSERT_NEAR(std::hypot(wi.x, wi.y) * eta, std::hypot(wo.x, wo.y), 1e-6);  // Snell
        const DielectricFresnel out = fresnel_dielectric(-wi.z, 1 / eta);
        ASSERT_NEAR(out.reflectance, in.reflectance, 2e-5 + 1e-3 * in.reflectance);
        const vec3 back = refract_direction(wi, -h, -wi.z, out.cos_t, 1 / eta);
        ASSERT_NEAR(glm::distance(back, wo), 0, 2e-4);  // a grazing cosine returns from a rounded sine
    }
}

// int D cos dh = 1, and the visible normals' projected area is that of the surface: int G1(w) D dot(w, h)+ dh = cos(w)
// [Heitz 2014, Eq. 4 and 22], for every width.
TEST(Ggx, DistributionsAreNormalised) {
    for (const float alpha : {1e-4f, 1e-3f, 0.03f, 0.3f, 1.0f}) {
        const Ggx ggx{alpha};
        for (const float cosine : {1.0f, 0.6f, 0.1f}) {
            const vec3 w(std::sqrt(1 - cosine * cosine), 0, cosine);
            double area = 0, visible = 0;
            constexpr int kRings = 2000, kSteps = 64;
            const double range = std::log1p(1e5);
            for (int i = 0; i < kRings; ++i) {
                const double s = std::expm1((i + 0.5) / kRings * range), t = s * static_cast<double>(alpha);
                const double cos_h = 1 / std::sqrt(1 + t * t);
                const double ring = cos_h * cos_h * cos_h * t * static_cast<double>(alpha) * (1 + s) * range / kRings;
                for (int j = 0; j < kSteps; ++j) {
                    const double phi = 2 * M_PI * (j + 0.5) / kSteps, solid_angle = ring * 2 * M_PI / kSteps;
                    const vec3 h(dvec3(t * cos_h * std::cos(phi), t * cos_h * std::sin(phi), cos_h));
                    area += static_cast<double>(ggx.d(h) * h.z) * solid_angle;
                    visible += static_cast<double>(ggx.visible_pdf(w, h)) * solid_angle;
                }
            }
            EXPECT_NEAR(area, 1, 1e-3) << alpha;
            EXPECT_NEAR(visible, 1, 3e-3) << alpha << " " << cosine;
        }
    }
}

TEST(Ggx, NothingBreaksAtGrazingAngles) {
    RandomStream random(2, RandomDomain::Test, 0, 0);
    for (const float alpha : {1e-4f, 0.01f, 1.0f})
        for (const float cosine : {1e-7f, 1e-4f, 1.0f}) {
            const Ggx ggx{alpha};
            const vec3 wo(std::sqrt(1 - cosine * cosine), 0, cosine);
            for (int i = 0; i < 1000; ++i) {
                const vec2 u = i == 0 ? vec2(0) : i == 1 ? vec2(0x1.fffffep-1f) : random.next_2d();
                const vec3 h = ggx.sample_visible(wo, u);
                ASSERT_TRUE(h.z > 0 && std::isfinite(h.x) && std::fabs(glm::length(h) - 1) < 1e-5f);
                ASSERT_TRUE(std::isfinite(ggx.visible_pdf(wo, h)));
            }
        }
}

TEST(BsdfReciprocity, ReflectionIsSymmetricAndRefractionScalesWithTheIndex) { expect_reciprocity(CpuBsdfs(), 200); }

TEST(Bsdf, NothingIsNanFromMirrorToMattAndGrazing) { expect_no_nan(CpuBsdfs()); }

TEST(Bsdf, AnIndexOfOneIsInvisible) {
    for (const float roughness : {0.0f, 0.3f, 1.0f}) {
        const Bsdf solid =
            Bsdf::layered({.roughness = roughness, .ior = 1.0f, .transmission = 1, .solid = true, .eta = 1.0f});
        EXPECT_FALSE(solid.has_non_delta());
        for (const float u : {0.0f, 0.5f, 0.999f}) {
            const vec3 wo = glm::normalize(vec3(0.8f, -0.3f, 0.1f));
            const BsdfSample s = solid.sample(wo, u, vec2(u, 0.3f));
            ASSERT_TRUE(s.valid() && s.delta && s.transmission);
            EXPECT_EQ(s.wi, -wo);
            EXPECT_EQ(s.weight, Rgb(1));
        }
    }
    const Bsdf sheet = Bsdf::layered({.roughness = 0, .ior = 1.0f, .transmission = 1});
    const vec3 wo = glm::normalize(vec3(0.8f, -0.3f, 0.01f));
    const BsdfSample s = sheet.sample(wo, 0.5f, vec2(0.5f));
    EXPECT_NEAR(glm::distance(s.wi, -wo), 0, 1e-6);
    EXPECT_NEAR(s.weight.x, 1, 1e-5);
}

TEST(Bsdf, NoSpecularIsPlainLambert) {
    const Rgb rho(0.7f, 0.2f, 0.1f);
    const Bsdf plain = Bsdf::lambert(vec3(0, 0, 1), rho);
    const Bsdf layered = Bsdf::layered({.base_color = rho, .specular = 0});
    RandomStream random(5, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 100; ++i) {
        const vec3 wo = cosine_direction(random), wi = cosine_direction(random);
        expect_equal(layered.f_cos(wo, wi), plain.f_cos(wo, wi), 1e-6, "f");
        EXPECT_NEAR(layered.pdf_sa(wo, wi), wi.z * kInvPi, 1e-6);
        EXPECT_FLOAT_EQ(plain.pdf_sa(wo, wi), wi.z * kInvPi);
        expect_equal(plain.f_cos(wo, wi), rho * (wi.z * kInvPi), 1e-6, "f");
    }
    expect_equal(layered.albedo(), rho, 1e-6, "albedo");
}

// Light may not pass a surface where a shading normal leans: reflection only to the geometric eye side.
TEST(Bsdf, GeometryDecidesTheSide) {
    const vec3 geometric = glm::normalize(vec3(0.6f, 0, 0.8f));
    const vec3 wo = glm::normalize(vec3(0.3f, 0.1f, 0.9f)), behind = glm::normalize(vec3(-0.95f, 0, 0.3f));
    ASSERT_LT(glm::dot(behind, geometric), 0);
    for (const float transmission : {0.0f, 1.0f}) {
        const Bsdf bsdf = Bsdf::layered(
            {.geometric_normal = geometric, .roughness = 0.8f, .transmission = transmission, .solid = true});
        EXPECT_TRUE(is_black(bsdf.f_cos(wo, behind)));  // above the shading, below the geometric surface
        RandomStream random(6, RandomDomain::Test, 0, 0);
        for (int i = 0; i < 2000; ++i) {
            const BsdfSample s = bsdf.sample(wo, random.next(), random.next_2d());
            ASSERT_TRUE(!s.valid() || (glm::dot(s.wi, geometric) < 0) == s.transmission);
        }
    }
    EXPECT_TRUE(is_black(Bsdf::lambert(geometric, Rgb(1)).f_cos(wo, behind)));
}

}  // namespace
}  // namespace photond::microfacet_test
