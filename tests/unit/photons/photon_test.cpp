// The record of a photon: 32 bytes, and what is lost in them.

#include "renderer/photons/photon.h"

#include <gtest/gtest.h>

#include "renderer/core/rng.h"
#include "renderer/transport/sampling.h"

namespace photond::photon_test {
namespace {

const vec3 kAxes[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};

vec3 on_sphere(RandomStream& random) {
    const float z = 2 * random.next() - 1, phi = 2 * kPi * random.next();
    const float s = std::sqrt(std::max(0.0f, 1 - z * z));
    return {s * std::cos(phi), s * std::sin(phi), z};
}

double angle(const vec3& a, const vec3& b) {
    return std::atan2(glm::length(glm::cross(dvec3(a), dvec3(b))), glm::dot(dvec3(a), dvec3(b)));
}

template <uint32_t kBits>
double greatest_error() {
    double greatest = 0;
    const auto look = [&](const vec3& n) {
        const vec3 back = Octahedral<kBits>::decode(Octahedral<kBits>::encode(n));
        EXPECT_NEAR(glm::length(back), 1.0f, 1e-6f);
        greatest = std::max(greatest, angle(n, back));
    };
    RandomStream random(1, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 400'000; ++i) look(on_sphere(random));
    // Where the octahedron is folded: about the equator and the seams of the lower half.
    for (int i = 0; i < 40'000; ++i) {
        vec3 n = on_sphere(random);
        n[i % 3] *= 1e-4f;
        if (i % 2) n[(i + 1) % 3] *= 1e-3f;
        look(glm::normalize(n));
    }
    return greatest;
}

TEST(Octahedral, ErrorsStayBelowWhatTheHeaderSays) {
    EXPECT_LT(greatest_error<16>(), 7e-5);
    EXPECT_LT(greatest_error<11>(), 2.1e-3);
}

TEST(Octahedral, AxesComeBackAsTheyWere) {
    for (const vec3& axis : kAxes) {
        EXPECT_EQ(Octahedral<11>::decode(Octahedral<11>::encode(axis)), axis);
        EXPECT_EQ(Octahedral<16>::decode(Octahedral<16>::encode(axis)), axis);
        const vec3 negative_zeros(axis.x == 0 ? -0.0f : axis.x, axis.y == 0 ? -0.0f : axis.y,
                                  axis.z == 0 ? -0.0f : axis.z);
        EXPECT_EQ(Octahedral<16>::decode(Octahedral<16>::encode(negative_zeros)), axis);
    }
}

TEST(Octahedral, EveryCodeIsAUnitVector) {
    for (uint32_t code = 0; code < 1u << 22; ++code) {
        const vec3 n = Octahedral<11>::decode(code);
        ASSERT_NEAR(glm::dot(n, n), 1.0f, 1e-5f) << code;
    }
}

TEST(PhotonPayload, KeepsEveryFieldApart) {
    RandomStream random(2, RandomDomain::Test, 0, 0);
    for (uint32_t scatterings = 0; scatterings < 300; ++scatterings) {
        for (const uint32_t flags : {0u, 1u, 2u, 3u}) {
            const bool all_delta = flags & 1, marked = flags & 2;
            const vec3 wi = on_sphere(random), normal = on_sphere(random);
            const Rgb power(random.next(), 1e-30f, 1e30f);
            const PhotonPayload photon = PhotonPayload::make(power, wi, normal, scatterings, all_delta, marked);
            EXPECT_EQ(photon.power_w, power);
            EXPECT_LT(angle(photon.wi_world(), wi), 7e-5);
            EXPECT_LT(angle(photon.normal(), normal), 2.1e-3);
            EXPECT_EQ(photon.scatterings(), std::min(scatterings, PhotonPayload::kMostScatterings));
            EXPECT_EQ(photon.all_delta(), all_delta);
            EXPECT_EQ(photon.marked(), marked);
        }
    }
    const PhotonPayload many = PhotonPayload::make(Rgb(1), kAxes[0], kAxes[5], UINT32_MAX, false);
    EXPECT_EQ(many.scatterings(), PhotonPayload::kMostScatterings);
    EXPECT_EQ(many.normal(), kAxes[5]);
    EXPECT_FALSE(many.all_delta());
    EXPECT_FALSE(many.marked());
}

// Paths one after another and scatterings one after another, as they come: of 2^20 the share lies within six standard
// deviations, 2.5e-3, of a quarter.
TEST(PhotonMarks, AreOneOfFourAndIndependent) {
    constexpr int kPaths = 1 << 18;
    int marked = 0, of_both = 0;
    for (uint64_t path = 0; path < kPaths; ++path) {
        for (uint32_t scatterings = 1; scatterings <= 4; ++scatterings) marked += is_marked_photon(path, scatterings);
        of_both += is_marked_photon(path, 1) && is_marked_photon(path, 2);
    }
    EXPECT_NEAR(marked / (4.0 * kPaths), 1 / 4.0, 6 * std::sqrt(3 / 16.0 / (4 * kPaths)));
    EXPECT_NEAR(double(of_both) / kPaths, 1 / 16.0, 6 * std::sqrt(15 / 256.0 / kPaths));
}

}  // namespace
}  // namespace photond::photon_test
