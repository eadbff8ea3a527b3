// The recursion of weights against the densities themselves: for paths whose densities are drawn at random, each
// technique rebuilds its own two sub-paths step by step, and its weight must be its density over the sum of all; over
// all techniques of a path the weights sum to 1. With radii, connections and merging of the pixel, with both
// heuristics, with lights of every kind and delta scatterings in between.

#include "renderer/bidirectional/mis_weights.h"

#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "renderer/bidirectional/merging_correlation.h"
#include "renderer/core/rng.h"

namespace photond::mis_weights_test {
namespace {

enum class Light { Area, Point, Directional, Environment };

/// A path from the light x_0 over the surfaces x_1 ... x_(k-1) to the camera x_k, and all that is known of it.
struct Path {
    Light light;
    BasicLightEnd<double> end;
    double camera_pdf;  // [1/sr]; orthographic [1/m^2]
    bool orthographic;
    std::vector<double> distance_sq;          // [i]: from x_i to x_(i+1)
    std::vector<double> cos_back, cos_ahead;  // at x_i, of the directions to x_(i-1) and x_(i+1)
    std::vector<double> eye_pdf, light_pdf;   // [1/sr] at x_i: of eye paths to x_(i-1), of light paths to x_(i+1)
    std::vector<double> acceptance;           // of merging at x_i, but of caustics
    double first_distance;                    // by which correlated merging counts
    std::vector<bool> delta;
    size_t surfaces() const { return delta.size() - 2; }  // x_0 and x_k have places, too
    /// The acceptance with which a light path merges at x_i.
    double merges_at(size_t i, double caustic_area) const {
        bool caustic = i > 1;
        for (size_t j = 1; j < i; ++j) caustic = caustic && delta[j];
        return caustic ? caustic_area * acceptance[i] : acceptance[i];
    }
};

Path random_path(RandomStream& random, size_t surfaces, Light light) {
    const auto number = [&](double low, double high) { return low * std::pow(high / low, double{random.next()}); };
    Path path;
    path.light = light;
    path.end = {.direct = number(0.01, 10),
                .emission = number(0.01, 10),
                .cosine = light == Light::Area ? number(0.05, 1) : 1,
                .delta = light == Light::Point || light == Light::Directional,
                .infinite = light == Light::Directional || light == Light::Environment};
    path.camera_pdf = number(10, 1e5);
    path.orthographic = random.next() < 0.3f;
    path.first_distance = number(1, 60);
    for (size_t i = 0; i < surfaces + 2; ++i) {
        path.distance_sq.push_back(number(0.05, 5));
        path.cos_back.push_back(number(0.05, 1)), path.cos_ahead.push_back(number(0.05, 1));
        path.eye_pdf.push_back(number(0.02, 20)), path.light_pdf.push_back(number(0.02, 20));
        path.acceptance.push_back(number(1e-5, 0.1));
        path.delta.push_back(i > 0 && i <= surfaces && random.next() < 0.25f);
    }
    return path;
}

/// Over the common measure of all techniques; delta scatterings have the density 1 on both sides.
class Densities {
public:
    Densities(const Path& path, const BasicTechniqueNumbers<double>& numbers, bool correlated)
        : path_(path), n_(numbers), correlated_(correlated) {}

    /// Of the eye's path having x_i, i > 0 its surface, from the camera; of i = 0 the light it meets.
    double eye(size_t i) const {
        const size_t k = path_.surfaces() + 1;
        if (i == k - 1) return path_.camera_pdf * path_.cos_ahead[i] / (path_.orthographic ? 1 : path_.distance_sq[i]);
        const double scattered = path_.delta[i + 1] ? 1 : path_.eye_pdf[i + 1];
        if (i == 0) return path_.end.infinite ? scattered : scattered * path_.end.cosine / path_.distance_sq[0];
        return scattered * path_.cos_ahead[i] / path_.distance_sq[i];
    }
    /// Of the light's path having x_i; of x_0 and x_1 together.
    double light(size_t i) const {
        if (i == 1) return path_.end.emission * path_.cos_back[1] / (path_.end.infinite ? 1 : path_.distance_sq[0]);
        const double scattered = path_.delta[i - 1] ? 1 : path_.light_pdf[i - 1];
        return scattered * path_.cos_back[i] / path_.distance_sq[i - 1];
    }
    double lights(size_t from, size_t to) const {  // x_0 ... x_to, from is 0 or 1
        double p = 1;
        for (size_t i = std::max<size_t>(from, 1); i <= to; ++i) p *= light(i);
        return p;
    }
    double eyes(size_t from) const {  // x_from ... x_(k-1)
        double p = 1;
        for (size_t i = from; i <= path_.surfaces(); ++i) p *= eye(i);
        return p;
    }

    /// Number times density of the technique with `lit` vertices from the light: 0 the light is met, 1 light sample, up
    /// to k, which the camera sees.
    double joined(size_t lit) const {
        const size_t k = path_.surfaces() + 1;
        if (lit == 0) return path_.end.delta || path_.surfaces() == 0 ? 0 : eyes(1) * eye(0);
        if (path_.delta[lit]) return 0;
        if (lit == 1) return path_.end.direct * eyes(1);
        if (path_.delta[lit - 1]) return 0;
        if (lit == k) return n_.light_paths * lights(0, k - 1);
        return n_.connections * lights(0, lit - 1) * eyes(lit);
    }
    /// ... with x_i merged.
    double merged(size_t i) const {
        if (!n_.merges || path_.delta[i]) return 0;
        return n_.light_paths * path_.merges_at(i, n_.caustic_area()) * lights(0, i) * eyes(i) *
               (correlated_ ? share(i) : 1);
    }
    /// kappa at x_i, as its source defines it.
    double share(size_t i) const {
        if (i == path_.surfaces()) return 1;
        const double radius = path_.first_distance * std::tan(std::numbers::pi / 180);
        const double region = std::numbers::pi * radius * radius;
        const bool from_surface = path_.light == Light::Area;
        double camera = 1, light_reach = std::min(1.0, light(1) * region * (from_surface ? region : 1));
        for (size_t j = i; j <= path_.surfaces(); ++j)
            if (j == path_.surfaces() || !path_.delta[j + 1]) camera *= std::min(1.0, eye(j) * region);
        for (size_t j = 2; j <= i; ++j)
            if (!path_.delta[j - 1]) light_reach *= std::min(1.0, light(j) * region);
        return std::max(camera / (camera + light_reach - camera * light_reach), 1 / n_.light_paths);
    }

private:
    const Path& path_;
    const BasicTechniqueNumbers<double>& n_;
    const bool correlated_;
};

/// Sub-paths as the renderer builds them, step by step.
template <class Real>
class Walk {
public:
    using Vertex = BasicPathVertex<Real>;

    /// `correlation`: nullptr where weights know nothing of it.
    Walk(const Path& path, const BasicMis<Real>& mis, const BasicTechniqueNumbers<Real>& numbers,
         const BasicMergingCorrelation<Real>* correlation)
        : path_(path), mis_(mis), n_(numbers), correlation_(correlation) {
        end_ = {Real(path.end.direct), Real(path.end.emission), Real(path.end.cosine), path.end.delta,
                path.end.infinite};
    }

    /// The light's path at x_last, arrived.
    BasicSubpathWeights<Real> light(size_t last) const {
        auto w = mis_.start_light(end_);
        mis_.direct_at_first_hit(w, end_.direct);
        mis_.arrive(w, end_.infinite ? Real(1) : real(path_.distance_sq[0]), real(path_.cos_back[1]));
        for (size_t i = 1; i < last; ++i) {
            if (path_.delta[i])
                mis_.scatter_delta(w, real(path_.cos_ahead[i]));
            else
                mis_.scatter(w, light_side(i), real(path_.light_pdf[i]), real(path_.cos_ahead[i]));
            mis_.arrive(w, real(path_.distance_sq[i]), real(path_.cos_back[i + 1]));
        }
        return w;
    }
    /// The eye's path at x_last; at x_0 it has met the light.
    BasicSubpathWeights<Real> eye(size_t last) const {
        const size_t k = path_.surfaces() + 1;
        auto w = mis_.start_eye(real(path_.camera_pdf));
        mis_.arrive(w, path_.orthographic ? Real(1) : real(path_.distance_sq[k - 1]), real(path_.cos_ahead[k - 1]));
        for (size_t i = k - 1; i > last; --i) {
            if (path_.delta[i])
                mis_.scatter_delta(w, real(path_.cos_back[i]));
            else
                mis_.scatter(w, eye_side(i), real(path_.eye_pdf[i]), real(path_.cos_back[i]));
            if (i > 1)
                mis_.arrive(w, real(path_.distance_sq[i - 1]), real(path_.cos_ahead[i - 1]));
            else if (!end_.infinite)
                mis_.arrive(w, real(path_.distance_sq[0]), end_.cosine);
        }
        return w;
    }

    Real joined(size_t lit) const {
        const size_t k = path_.surfaces() + 1;
        const Real first_sq = end_.infinite ? Real(1) : real(path_.distance_sq[0]);
        const auto first = first_of_light(end_, real(path_.cos_back[1]), first_sq);
        if (lit == 0) {
            auto w = eye(0);
            if (correlation_) {
                const Real inverse_cos = end_.infinite ? Real(1) : 1 / end_.cosine;
                w.merges = correlation_->light_met(eye_vertices(1), inverse_cos, first, n_.caustic_area()).eye;
                w.newest_merge = 0;
            }
            return mis_.light_met(w, end_, n_);
        }
        if (lit == 1) {
            Real direct_sa = end_.direct;
            if (!end_.infinite) direct_sa *= real(path_.distance_sq[0]) / end_.cosine;
            auto w = eye(1);
            auto side = eye_side(1);
            if (correlation_) {
                const auto merges = correlation_->next_event(eye_vertices(1), side.pdf_back, first);
                w.merges = merges.eye, side.acceptance *= merges.eye_share;
            }
            return mis_.next_event(w, side, real(path_.eye_pdf[1]), direct_sa, real(path_.cos_back[1]), end_, n_);
        }
        if (lit == k) {
            const Real camera =
                real(path_.camera_pdf * path_.cos_ahead[k - 1] / (path_.orthographic ? 1 : path_.distance_sq[k - 1]));
            auto w = light(k - 1);
            const auto side = light_side(k - 1);
            if (correlation_)
                w.merges = correlation_->seen_by_camera(light_vertices(k - 1), side.pdf_back, camera).light;
            return mis_.seen_by_camera(w, side, camera, n_);
        }
        const Real d = real(path_.distance_sq[lit - 1]);
        const Real to_light = real(path_.eye_pdf[lit] * path_.cos_ahead[lit - 1]) / d,
                   to_eye = real(path_.light_pdf[lit - 1] * path_.cos_back[lit]) / d;
        auto from_eye = eye(lit), from_light = light(lit - 1);
        auto at_eye = eye_side(lit), at_light = light_side(lit - 1);
        if (correlation_) {
            const auto merges = correlation_->connection(eye_vertices(lit), at_eye.pdf_back, to_light,
                                                         light_vertices(lit - 1), at_light.pdf_back, to_eye);
            from_eye.merges = merges.eye, at_eye.acceptance *= merges.eye_share;
            from_light.merges = merges.light, at_light.acceptance *= merges.light_share;
        }
        return mis_.connection(from_eye, at_eye, to_light, from_light, at_light, to_eye, n_);
    }
    Real merged(size_t i) const {
        auto from_eye = eye(i), from_light = light(i);
        auto at_eye = eye_side(i);
        const auto at_light = light_side(i);
        at_eye.acceptance = at_light.acceptance;
        if (correlation_) {
            const auto merges =
                correlation_->merging(eye_vertices(i), at_eye.pdf_back, light_vertices(i), at_light.pdf_back);
            from_eye.merges = merges.eye, at_eye.acceptance *= merges.eye_share;
            from_light.merges = merges.light;
        }
        return mis_.merging(from_eye, at_eye, from_light, at_light, n_);
    }

private:
    static Real real(double x) { return static_cast<Real>(x); }
    BasicVertexSide<Real> light_side(size_t i) const {
        return {i == 1, real(path_.eye_pdf[i]), real(path_.merges_at(i, double(n_.caustic_area())))};
    }
    BasicVertexSide<Real> eye_side(size_t i) const {
        return {i == path_.surfaces(), real(path_.light_pdf[i]), real(path_.acceptance[i])};
    }

    /// x_1 ... x_last as the light's path met them.
    std::vector<Vertex> light_vertices(size_t last) const {
        std::vector<Vertex> vertices;
        for (size_t i = 1; i <= last; ++i) {
            const Real pdf = path_.delta[i] ? Real(1) : real(path_.light_pdf[i]);
            Vertex v{.acceptance = light_side(i).acceptance,
                     .inverse_cos = 1 / real(path_.cos_back[i]),
                     .onward = real(path_.cos_ahead[i]) / pdf,
                     .pdf_back = real(path_.eye_pdf[i]),
                     .per_area = real(path_.cos_ahead[i]) / real(path_.distance_sq[i]),
                     .delta = path_.delta[i]};
            const Real cosine = real(path_.cos_back[i]), distance_sq = real(path_.distance_sq[i - 1]);
            if (i == 1) {
                const Vertex first = first_of_light(end_, cosine, distance_sq);
                v.density = first.density, v.of_two_areas = first.of_two_areas;
            } else {
                v.density = path_.delta[i - 1] ? kInfinite : real(path_.light_pdf[i - 1]) * cosine / distance_sq;
            }
            vertices.push_back(v);
        }
        correlation_->find_reach(vertices);
        return vertices;
    }
    /// x_(k-1) ... x_last as the eye's path met them.
    std::vector<Vertex> eye_vertices(size_t last) const {
        std::vector<Vertex> vertices;
        const size_t k = path_.surfaces() + 1;
        for (size_t i = k - 1; i >= last; --i) {
            const Real pdf = path_.delta[i] ? Real(1) : real(path_.eye_pdf[i]);
            Vertex v{
                .acceptance = real(path_.acceptance[i]),
                .inverse_cos = 1 / real(path_.cos_ahead[i]),
                .onward = real(path_.cos_back[i]) / pdf,
                .pdf_back = real(path_.light_pdf[i]),
                .per_area = real(path_.cos_back[i]) / (i == 1 && end_.infinite ? 1 : real(path_.distance_sq[i - 1])),
                .delta = path_.delta[i]};
            const Real cosine = real(path_.cos_ahead[i]), distance_sq = real(path_.distance_sq[i]);
            if (i == k - 1)
                v.density = real(path_.camera_pdf) * cosine / (path_.orthographic ? 1 : distance_sq);
            else
                v.density = path_.delta[i + 1] ? kInfinite : real(path_.eye_pdf[i + 1]) * cosine / distance_sq;
            vertices.push_back(v);
        }
        correlation_->find_reach(vertices);
        return vertices;
    }

    static constexpr Real kInfinite = std::numeric_limits<Real>::infinity();
    const Path& path_;
    const BasicMis<Real>& mis_;
    const BasicTechniqueNumbers<Real>& n_;
    const BasicMergingCorrelation<Real>* correlation_;
    BasicLightEnd<Real> end_;
};

template <class Real>
void expect_weights_of_densities(MisHeuristic heuristic, double tolerance, bool correlated) {
    RandomStream random(7, RandomDomain::Test, 0, 0);
    const BasicMis<Real> mis(heuristic);
    size_t techniques = 0;
    for (int repeat = 0; repeat < 400; ++repeat)
        for (const Light light : {Light::Area, Light::Point, Light::Directional, Light::Environment}) {
            const Path path = random_path(random, 1 + size_t(repeat) % 6, light);
            const BasicTechniqueNumbers<double> exact{.light_paths = 1 + 1000 * double{random.next()},
                                                      .connections = repeat % 3 == 0 ? 0 : 4 * double{random.next()},
                                                      .merges = repeat % 2 == 0,
                                                      .caustic_radius = repeat % 4 == 0 ? 1 : double{random.next()}};
            const BasicTechniqueNumbers<Real> numbers{Real(exact.light_paths), Real(exact.connections), exact.merges,
                                                      Real(exact.caustic_radius)};
            const BasicMergingCorrelation<Real> correlation(heuristic, Real(path.first_distance), numbers.light_paths);
            const Densities densities(path, exact, correlated);
            const Walk<Real> walk(path, mis, numbers, correlated ? &correlation : nullptr);
            const auto squared = [&](double p) { return heuristic == MisHeuristic::Power ? p * p : p; };
            const size_t k = path.surfaces() + 1;
            double all = 0;
            for (size_t lit = 0; lit <= k; ++lit) all += squared(densities.joined(lit));
            for (size_t i = 1; i < k; ++i) all += squared(densities.merged(i));
            if (!(all > 0)) continue;  // delta scatterings at every turn: no technique makes it
            double sum = 0;
            for (size_t lit = 0; lit <= k; ++lit) {
                if (!(densities.joined(lit) > 0)) continue;
                const double weight = static_cast<double>(walk.joined(lit));
                EXPECT_NEAR(weight, squared(densities.joined(lit)) / all, tolerance)
                    << lit << " vertices of the light's path, of " << k + 1;
                sum += weight, ++techniques;
            }
            for (size_t i = 1; i < k; ++i) {
                if (!(densities.merged(i) > 0)) continue;
                const double weight = static_cast<double>(walk.merged(i));
                EXPECT_NEAR(weight, squared(densities.merged(i)) / all, tolerance) << "merged at " << i;
                sum += weight, ++techniques;
            }
            ASSERT_NEAR(sum, 1, 10 * tolerance);
        }
    EXPECT_GT(techniques, 3000u);
}

TEST(MisWeights, AreDensitiesOverTheSumOfAll) {
    for (const bool correlated : {false, true}) {
        expect_weights_of_densities<double>(MisHeuristic::Balance, 1e-10, correlated);
        expect_weights_of_densities<double>(MisHeuristic::Power, 1e-10, correlated);
    }
}

TEST(MisWeights, InFloatToo) {
    for (const bool correlated : {false, true}) {
        expect_weights_of_densities<float>(MisHeuristic::Balance, 1e-5, correlated);
        expect_weights_of_densities<float>(MisHeuristic::Power, 1e-5, correlated);
    }
}

TEST(MisWeights, DensitiesPastTheRangeOfFloatWeighNothing) {
    const Mis mis(MisHeuristic::Power);
    SubpathWeights eye = mis.start_eye(1e-30f);
    mis.arrive(eye, 1, 1e-12f);
    const float weight = mis.light_met(eye, {.direct = 1, .emission = 1}, {.light_paths = 1});
    EXPECT_EQ(weight, 0);
    EXPECT_GE(mis.merging(eye, {true, 0, 1}, eye, {true, 0, 1}, {.light_paths = 1, .connections = 1, .merges = true}),
              0);
}

}  // namespace
}  // namespace photond::mis_weights_test
