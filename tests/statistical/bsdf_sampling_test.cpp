// Every lobe and mixture of lobes is sampled with the density it states (chi-square over half-vectors), and the weights
// of the samples average to the integral of what evaluate() returns.

#include <gtest/gtest.h>

#include <map>

#include "renderer/core/rng.h"
#include "tests/support/bsdf_quadrature.h"
#include "tests/support/statistics.h"

namespace photond {
namespace {

using namespace test;

constexpr double kFalseAlarm = 1e-6;  // of all checks of this program together
constexpr int kDraws = 300'000;
constexpr CellGrid kGrid{18, 10, 28};
constexpr float kRoughnesses[] = {0.01f, 0.05f, 0.2f, 0.5f, 1.0f};
constexpr double kCosines[] = {0.9999, 0.7, 0.2, 0.02};

Bsdf::Parameters coloured(float roughness) {
    Bsdf::Parameters p;
    p.base_color = Rgb(0.8f, 0.5f, 0.2f);
    p.roughness = roughness;
    return p;
}

struct NamedBsdf {
    const char* name;
    Bsdf::Parameters parameters;
    Side far_side = Side::Mirrored;
};

std::vector<NamedBsdf> materials(float roughness) {
    std::vector<NamedBsdf> list(8, {"coated diffuse", coloured(roughness)});
    list[1].name = "metal", list[1].parameters.metallic = 1;
    list[2].name = "half metal, tilted geometry", list[2].parameters.metallic = 0.5f;
    list[2].parameters.geometric_normal = vec3(direction_at(0.85, 0.3));
    list[3].name = "thin sheet", list[3].parameters.transmission = 1;
    list[4].name = "half a thin sheet", list[4].parameters.transmission = 0.5f;
    list[4].parameters.specular_color = Rgb(1, 0.5f, 3);
    list[5].name = "glass from outside";
    list[6].name = "glass from inside", list[6].parameters.eta = 1 / 1.5f;
    list[7].name = "half glass, half metal", list[7].parameters.metallic = 0.5f;
    list[7].parameters.specular = 0.6f, list[7].parameters.eta = 1.2f;
    for (size_t i = 5; i < 8; ++i) {
        list[i].far_side = Side::Refracted;
        list[i].parameters.solid = true;
        list[i].parameters.transmission = i == 7 ? 0.5f : 1.0f;
    }
    return list;
}

/// What a number of draws did: how many fell into each cell of either side, and what their weights add up to.
struct Draws {
    std::vector<double> near, far;
    double lost = 0, wrong_side = 0, wrong_pdf = 0;
    RunningMean weight[3];
};

Draws draw(const Bsdf& bsdf, const ScatteringMap& map, Side far_side, uint64_t stream) {
    Draws draws;
    draws.near.assign(kGrid.cells(), 0), draws.far.assign(kGrid.cells(), 0);
    RandomStream random(7, RandomDomain::Test, 0, stream);
    const vec3 wo(map.wo);
    for (int i = 0; i < kDraws; ++i) {
        const float u_lobe = random.next();
        const BsdfSample s = bsdf.sample(wo, u_lobe, random.next_2d(), TransportMode::Importance);
        for (int c = 0; c < 3; ++c) draws.weight[c].add(s.valid() ? s.weight[c] : 0);
        if (!s.valid()) {
            ++draws.lost;
            continue;
        }
        draws.wrong_side += s.transmission != (s.wi.z < 0);
        const Side side = s.transmission ? far_side : Side::Reflected;
        ++(s.transmission ? draws.far : draws.near)[kGrid.cell(map.half_vectors, map.half_vector(side, dvec3(s.wi)))];
        draws.wrong_pdf += std::fabs(bsdf.pdf_sa(wo, s.wi) / s.pdf_sa - 1) > 1e-4f;
    }
    return draws;
}

/// Probability of draws like these if the densities are those of `stated`.
double agreement(const Draws& draws, const CellIntegrals& near, const CellIntegrals& far) {
    std::vector<double> observed = draws.near, expected = near.pdf;
    observed.insert(observed.end(), draws.far.begin(), draws.far.end());
    expected.insert(expected.end(), far.pdf.begin(), far.pdf.end());
    // Draws may be lost below the horizon. Of densities that leave out less than 1e-3 that is not asked: half-vectors
    // of rounded directions err by as much at the narrowest lobes.
    if (const double lost = 1 - near.total_pdf() - far.total_pdf(); lost > 1e-3) {
        observed.push_back(draws.lost);
        expected.push_back(lost);
    }
    for (double& x : expected) x *= kDraws;
    // A cell the quadrature's points miss altogether holds next to nothing; chance may still put a draw there.
    for (double& x : expected) x = std::max(x, 1e-3);
    return chi_square_probability(observed, expected);
}

TEST(BsdfSampling, DensitiesAndWeightsAreAsStated) {
    const double checks = double(std::size(kRoughnesses) * std::size(kCosines) * 8);
    const double share = share_of_false_alarm(kFalseAlarm, size_t(4 * checks));
    uint64_t stream = 0;
    for (const float roughness : kRoughnesses)
        for (const NamedBsdf& material : materials(roughness))
            for (const double cos_theta : kCosines) {
                SCOPED_TRACE(testing::Message()
                             << material.name << ", roughness " << roughness << ", cos " << cos_theta);
                const Bsdf bsdf = Bsdf::layered(material.parameters);
                const ScatteringMap map{HalfVectorMap(sqr(roughness)), direction_at(cos_theta, 0.1),
                                        static_cast<double>(material.parameters.eta)};
                const CellIntegrals near = integrate_bsdf(bsdf, map, Side::Reflected, kGrid);
                const CellIntegrals far = integrate_bsdf(bsdf, map, material.far_side, kGrid);
                const Draws draws = draw(bsdf, map, material.far_side, ++stream);
                EXPECT_LE(near.total_pdf() + far.total_pdf(), 1 + 2e-3);
                EXPECT_EQ(draws.wrong_side, 0);
                EXPECT_EQ(draws.wrong_pdf, 0);
                EXPECT_GT(agreement(draws, near, far), share);
                for (int c = 0; c < 3; ++c)
                    EXPECT_NEAR(draws.weight[c].mean(), near.f_cos[c] + far.f_cos[c],
                                two_sided_z(share) * draws.weight[c].standard_error() + 1e-3);
            }
}

// The other half of the promise: draws from a lobe whose roughness is 3 % off are told apart, wide or narrow.
TEST(BsdfSampling, ALobeThreePercentTooWideIsNoticed) {
    for (const float roughness : {0.01f, 0.2f, 0.7f})
        for (const size_t which : {1u, 3u, 5u}) {
            const NamedBsdf right = materials(roughness)[which], wrong = materials(1.03f * roughness)[which];
            const ScatteringMap map{HalfVectorMap(sqr(roughness)), direction_at(0.7, 0.1),
                                    static_cast<double>(right.parameters.eta)};
            const Bsdf stated = Bsdf::layered(right.parameters);
            const Draws draws = draw(Bsdf::layered(wrong.parameters), map, right.far_side, which);
            EXPECT_LT(agreement(draws, integrate_bsdf(stated, map, Side::Reflected, kGrid),
                                integrate_bsdf(stated, map, right.far_side, kGrid)),
                      1e-9)
                << right.name << ", roughness " << roughness;
        }
}

TEST(BsdfSampling, DeltaLobesAreChosenAsOftenAsTheySay) {
    const double share = share_of_false_alarm(kFalseAlarm, 8 * std::size(kCosines));
    for (const NamedBsdf& material : materials(0.0f))
        for (const double cos_theta : kCosines) {
            SCOPED_TRACE(testing::Message() << material.name << ", cos " << cos_theta);
            const Bsdf bsdf = Bsdf::layered(material.parameters);
            ASSERT_TRUE(bsdf.has_delta());
            const vec3 wo(direction_at(cos_theta, 0.1));
            RandomStream random(8, RandomDomain::Test, 0, 0);
            std::map<std::pair<bool, float>, double>
                seen;  // by side and probability: a coat and a solid may both reflect
            constexpr int kDeltaDraws = 100'000;
            for (int i = 0; i < kDeltaDraws; ++i) {
                const float u_lobe = random.next();
                const BsdfSample s = bsdf.sample(wo, u_lobe, random.next_2d(), TransportMode::Importance);
                if (!s.valid() || !s.delta) continue;
                ++seen[{s.transmission, s.pdf_sa}];
                ASSERT_LE(bsdf.pdf_sa(wo, s.wi), kInvPi);  // the lobe itself has no density
            }
            if (seen.empty()) {  // the only direction leaves below the tilted geometric surface
                EXPECT_LT(glm::dot(vec3(-wo.x, -wo.y, wo.z), material.parameters.geometric_normal), 0);
                continue;
            }
            std::vector<double> observed, expected;
            double rest = 1, other = kDeltaDraws;
            for (const auto& [lobe, count] : seen) {
                observed.push_back(count);
                expected.push_back(kDeltaDraws * static_cast<double>(lobe.second));
                rest -= static_cast<double>(lobe.second), other -= count;
            }
            ASSERT_GE(rest, -1e-5);
            if (rest > 1e-5) {
                observed.push_back(other);
                expected.push_back(kDeltaDraws * rest);
            }
            if (observed.size() < 2) {
                EXPECT_NEAR(other, 0, 1);  // the only outcome there is
                continue;
            }
            const double probability = chi_square_probability(observed, expected);
            EXPECT_TRUE(std::isnan(probability) || probability > share) << probability;
        }
}

}  // namespace
}  // namespace photond
