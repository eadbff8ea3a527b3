#pragma once
// That BSDFs draw as they state, checked of whoever answers (bsdf_case.h): the C++ and its GLSL twin by the same code.

#include <gtest/gtest.h>

#include <map>

#include "tests/support/bsdf_case.h"
#include "tests/support/statistics.h"

namespace photond::test {

/// Of a check over many draws and angles.
struct BsdfSamplingSettings {
    double false_alarm;  // of the check as a whole
    size_t draws;        // of each BSDF and angle
    CellGrid grid;
    std::vector<float> roughnesses;
    std::vector<double> cosines;
};

inline Bsdf::Parameters coloured(float roughness) {
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

inline std::vector<NamedBsdf> coloured_materials(float roughness) {
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
    double count = 0, lost = 0, wrong_side = 0, wrong_pdf = 0;
    RunningMean weight[3];
};

template <class Bsdfs>
Draws draw(const Bsdfs& bsdfs, const NamedBsdf& material, const ScatteringMap& map, const CellGrid& grid, size_t count,
           uint64_t stream) {
    Draws draws;
    draws.count = static_cast<double>(count);
    draws.near.assign(grid.cells(), 0), draws.far.assign(grid.cells(), 0);
    const vec3 wo(map.wo);
    const std::vector<BsdfSample> samples =
        sample_case(bsdfs, material.parameters, wo, RandomStream(7, RandomDomain::Test, 0, stream), count);
    const std::vector<BsdfValue> stated = values_of(bsdfs, material.parameters, wo, samples);
    for (size_t i = 0; i < count; ++i) {
        const BsdfSample& s = samples[i];
        for (int c = 0; c < 3; ++c) draws.weight[c].add(s.valid() ? s.weight[c] : 0);
        if (!s.valid()) {
            ++draws.lost;
            continue;
        }
        draws.wrong_side += s.transmission != (s.wi.z < 0);
        const Side side = s.transmission ? material.far_side : Side::Reflected;
        ++(s.transmission ? draws.far : draws.near)[grid.cell(map.half_vectors, map.half_vector(side, dvec3(s.wi)))];
        draws.wrong_pdf += std::fabs(stated[i].pdf_sa / s.pdf_sa - 1) > 1e-4f;
    }
    return draws;
}

/// Probability of draws like these if the densities are those of `stated`.
inline double agreement(const Draws& draws, const CellIntegrals& near, const CellIntegrals& far) {
    std::vector<double> observed = draws.near, expected = near.pdf;
    observed.insert(observed.end(), draws.far.begin(), draws.far.end());
    expected.insert(expected.end(), far.pdf.begin(), far.pdf.end());
    // Draws may be lost below the horizon. Of densities that leave out less than 1e-3 that is not asked: half-vectors
    // of rounded directions err by as much at the narrowest lobes.
    if (const double lost = 1 - near.total_pdf() - far.total_pdf(); lost > 1e-3) {
        observed.push_back(draws.lost);
        expected.push_back(lost);
    }
    for (double& x : expected) x *= draws.count;
    // A cell the quadrature's points miss altogether holds next to nothing; chance may still put a draw there.
    for (double& x : expected) x = std::max(x, 1e-3);
    return chi_square_probability(observed, expected);
}

/// Every lobe and mixture of lobes is sampled with the density it states (chi-square over half-vectors), and the
/// weights of the samples average to the integral of the values.
template <class Bsdfs>
void expect_densities_and_weights_as_stated(const Bsdfs& bsdfs, const BsdfSamplingSettings& settings) {
    const size_t angles = settings.roughnesses.size() * settings.cosines.size();
    const double share = share_of_false_alarm(settings.false_alarm, 4 * 8 * angles);
    uint64_t stream = 0;
    for (const float roughness : settings.roughnesses)
        for (const NamedBsdf& material : coloured_materials(roughness))
            for (const double cos_theta : settings.cosines) {
                SCOPED_TRACE(testing::Message()
                             << material.name << ", roughness " << roughness << ", cos " << cos_theta);
                const ScatteringMap map{HalfVectorMap(sqr(roughness)), direction_at(cos_theta, 0.1),
                                        static_cast<double>(material.parameters.eta)};
                const CellIntegrals near =
                    integrate_case(bsdfs, material.parameters, map, Side::Reflected, settings.grid);
                const CellIntegrals far =
                    integrate_case(bsdfs, material.parameters, map, material.far_side, settings.grid);
                const Draws draws = draw(bsdfs, material, map, settings.grid, settings.draws, ++stream);
                EXPECT_LE(near.total_pdf() + far.total_pdf(), 1 + 2e-3);
                EXPECT_EQ(draws.wrong_side, 0);
                EXPECT_EQ(draws.wrong_pdf, 0);
                EXPECT_GT(agreement(draws, near, far), share);
                for (int c = 0; c < 3; ++c)
                    EXPECT_NEAR(draws.weight[c].mean(), near.f_cos[c] + far.f_cos[c],
                                two_sided_z(share) * draws.weight[c].standard_error() + 1e-3);
            }
}

/// The other half of the promise: draws from a lobe whose roughness is 3 % off are told apart, wide or narrow.
template <class Bsdfs>
void expect_lobes_three_percent_too_wide_are_noticed(const Bsdfs& bsdfs, size_t draw_count, const CellGrid& grid,
                                                     const std::vector<float>& roughnesses) {
    for (const float roughness : roughnesses)
        for (const size_t which : {1u, 3u, 5u}) {
            const NamedBsdf right = coloured_materials(roughness)[which];
            const NamedBsdf wrong = coloured_materials(1.03f * roughness)[which];
            const ScatteringMap map{HalfVectorMap(sqr(roughness)), direction_at(0.7, 0.1),
                                    static_cast<double>(right.parameters.eta)};
            const Draws draws = draw(bsdfs, wrong, map, grid, draw_count, which);
            EXPECT_LT(agreement(draws, integrate_case(bsdfs, right.parameters, map, Side::Reflected, grid),
                                integrate_case(bsdfs, right.parameters, map, right.far_side, grid)),
                      1e-9)
                << right.name << ", roughness " << roughness;
        }
}

/// Each delta lobe is chosen as often as its probability says.
template <class Bsdfs>
void expect_delta_lobes_chosen_as_often_as_they_say(const Bsdfs& bsdfs, double false_alarm, size_t draw_count,
                                                    const std::vector<double>& cosines) {
    const double share = share_of_false_alarm(false_alarm, 8 * cosines.size());
    const double draws = static_cast<double>(draw_count);
    for (const NamedBsdf& material : coloured_materials(0.0f))
        for (const double cos_theta : cosines) {
            SCOPED_TRACE(testing::Message() << material.name << ", cos " << cos_theta);
            const vec3 wo(direction_at(cos_theta, 0.1));
            const std::vector<BsdfSample> samples =
                sample_case(bsdfs, material.parameters, wo, RandomStream(8, RandomDomain::Test, 0, 0), draw_count);
            const std::vector<BsdfValue> values = values_of(bsdfs, material.parameters, wo, samples);
            std::map<std::pair<bool, float>, double>
                seen;  // by side and probability: a coat and a solid may both reflect
            for (size_t i = 0; i < draw_count; ++i) {
                const BsdfSample& s = samples[i];
                if (!s.valid() || !s.delta) continue;
                ++seen[{s.transmission, s.pdf_sa}];
                ASSERT_LE(values[i].pdf_sa, kInvPi);  // the lobe itself has no density
            }
            if (seen.empty()) {  // the only direction leaves below the tilted geometric surface
                EXPECT_LT(glm::dot(vec3(-wo.x, -wo.y, wo.z), material.parameters.geometric_normal), 0);
                continue;
            }
            std::vector<double> observed, expected;
            double rest = 1, other = draws;
            for (const auto& [lobe, count] : seen) {
                observed.push_back(count);
                expected.push_back(draws * static_cast<double>(lobe.second));
                rest -= static_cast<double>(lobe.second), other -= count;
            }
            ASSERT_GE(rest, -1e-5);
            if (rest > 1e-5) {
                observed.push_back(other);
                expected.push_back(draws * rest);
            }
            if (observed.size() < 2) {
                EXPECT_NEAR(other, 0, 1);  // the only outcome there is
                continue;
            }
            const double probability = chi_square_probability(observed, expected);
            EXPECT_TRUE(std::isnan(probability) || probability > share) << probability;
        }
}

}  // namespace photond::test
