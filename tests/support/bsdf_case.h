#pragma once
// BSDFs asked in bulk, whoever answers: the C++ here, its GLSL twin in gpu_bsdf.h. Tests of what both promise
// (bsdf_*_checks.h) are written for either.

#include <span>
#include <vector>

#include "renderer/core/rng.h"
#include "tests/support/bsdf_quadrature.h"

namespace photond::test {

enum class BsdfPart : uint32_t { Whole, Specular, Rough };

/// A BSDF as a test makes it.
struct BsdfCase {
    Bsdf::Parameters parameters;
    BsdfPart part = BsdfPart::Whole;
    float glossy_threshold = 0;
    TransportMode mode = TransportMode::Radiance;

    Bsdf make() const {
        const Bsdf bsdf = Bsdf::layered(parameters);
        return part == BsdfPart::Whole      ? bsdf
               : part == BsdfPart::Specular ? bsdf.specular_part(glossy_threshold)
                                            : bsdf.rough_part(glossy_threshold);
    }
};

/// A question about one of the cases; in the layout tests/gpu/bsdf.glsl reads.
struct BsdfQuery {
    uint32_t bsdf_case;
    vec3 wo;
    vec3 w;  // a direction to evaluate, or three numbers to sample by: u_lobe, u
};

/// Answers by the C++.
struct CpuBsdfs {
    std::vector<BsdfValue> evaluate(std::span<const BsdfCase> cases, std::span<const BsdfQuery> queries) const {
        const std::vector<Bsdf> bsdfs = make(cases);
        std::vector<BsdfValue> values;
        values.reserve(queries.size());
        for (const BsdfQuery& q : queries)
            values.push_back(bsdfs[q.bsdf_case].evaluate(q.wo, q.w, cases[q.bsdf_case].mode));
        return values;
    }
    std::vector<BsdfSample> sample(std::span<const BsdfCase> cases, std::span<const BsdfQuery> queries) const {
        const std::vector<Bsdf> bsdfs = make(cases);
        std::vector<BsdfSample> samples;
        samples.reserve(queries.size());
        for (const BsdfQuery& q : queries)
            samples.push_back(bsdfs[q.bsdf_case].sample(q.wo, q.w.x, vec2(q.w.y, q.w.z), cases[q.bsdf_case].mode));
        return samples;
    }

private:
    static std::vector<Bsdf> make(std::span<const BsdfCase> cases) {
        std::vector<Bsdf> bsdfs;
        for (const BsdfCase& c : cases) bsdfs.push_back(c.make());
        return bsdfs;
    }
};

/// Integrals of the values in Importance mode.
template <class Bsdfs>
CellIntegrals integrate_case(const Bsdfs& bsdfs, const Bsdf::Parameters& parameters, const ScatteringMap& map,
                             Side side, const CellGrid& grid) {
    const BsdfCase importance{.parameters = parameters, .mode = TransportMode::Importance};
    const auto evaluate = [&](std::span<const vec3> directions) {
        std::vector<BsdfQuery> queries;
        queries.reserve(directions.size());
        for (const vec3& wi : directions) queries.push_back({0, vec3(map.wo), wi});
        return bsdfs.evaluate(std::span(&importance, 1), queries);
    };
    return integrate_values(evaluate, map, side, grid);
}

/// `count` draws by three independent numbers each.
template <class Bsdfs>
std::vector<BsdfSample> sample_case(const Bsdfs& bsdfs, const Bsdf::Parameters& parameters, const vec3& wo,
                                    RandomStream random, size_t count) {
    const BsdfCase importance{.parameters = parameters, .mode = TransportMode::Importance};
    std::vector<BsdfQuery> queries(count);
    for (BsdfQuery& q : queries) {
        const float u_lobe = random.next();
        q = {0, wo, vec3(u_lobe, random.next_2d())};
    }
    return bsdfs.sample(std::span(&importance, 1), queries);
}

/// The densities that are stated for the directions of samples.
template <class Bsdfs>
std::vector<BsdfValue> values_of(const Bsdfs& bsdfs, const Bsdf::Parameters& parameters, const vec3& wo,
                                 std::span<const BsdfSample> samples) {
    const BsdfCase importance{.parameters = parameters, .mode = TransportMode::Importance};
    std::vector<BsdfQuery> queries;
    queries.reserve(samples.size());
    for (const BsdfSample& s : samples) queries.push_back({0, wo, s.wi});
    return bsdfs.evaluate(std::span(&importance, 1), queries);
}

}  // namespace photond::test
