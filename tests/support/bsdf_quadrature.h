#pragma once
// Quadrature of BSDFs over directions, in the half-vector's own coordinates, so that a lobe of any width fills cells of
// the same number. Independent of how the BSDF samples.

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "renderer/transport/bsdf.h"

namespace photond::test {

/// The half-vectors, by slope: q = log(1 + s) / L with s = tan(theta_h) / alpha, and azimuth, both in [0, 1]. L reaches
/// to within 1e-4 of the horizon.
struct HalfVectorMap {
    double alpha;
    double log_range;

    explicit HalfVectorMap(double ggx_alpha) : alpha(ggx_alpha), log_range(std::log1p(1e4 / ggx_alpha)) {}

    dvec3 direction(double q, double turn) const {
        const double tangent = alpha * std::expm1(q * log_range), phi = 2 * M_PI * turn;
        return glm::normalize(dvec3(tangent * std::cos(phi), tangent * std::sin(phi), 1));
    }
    /// Solid angle of dq dturn at h.
    double solid_angle(const dvec3& h, double q) const {
        const double s = std::expm1(q * log_range);
        return h.z * h.z * h.z * alpha * alpha * s * (1 + s) * log_range * 2 * M_PI;
    }
    double q(const dvec3& h) const { return std::log1p(std::hypot(h.x, h.y) / (h.z * alpha)) / log_range; }
    static double turn(const dvec3& h) { return 0.5 + std::atan2(-h.y, -h.x) / (2 * M_PI); }
};

/// How wi follows from wo and a half-vector.
enum class Side { Reflected, Refracted, Mirrored };  // mirrored: reflected, then turned to the far side (thin sheets)

struct ScatteringMap {
    HalfVectorMap half_vectors;
    dvec3 wo;
    double eta;

    /// wi, and the solid angle of dq dturn about it; 0 where there is no such direction.
    double scatter(Side side, double q, double turn, dvec3& wi) const {
        const dvec3 h = half_vectors.direction(q, turn);
        const double cos_o = glm::dot(wo, h);
        if (cos_o <= 0) return 0;
        const double solid_angle = half_vectors.solid_angle(h, q);
        if (side == Side::Refracted) {
            const double sin2_t = (1 - cos_o * cos_o) / (eta * eta);
            if (sin2_t >= 1) return 0;
            const double cos_t = std::sqrt(1 - sin2_t);
            wi = -wo / eta + (cos_o / eta - cos_t) * h;
            if (wi.z >= 0) return 0;
            const double root = cos_o - eta * cos_t;
            return solid_angle * root * root / (eta * eta * cos_t);
        }
        wi = 2 * cos_o * h - wo;
        if (wi.z <= 0) return 0;
        if (side == Side::Mirrored) wi.z = -wi.z;
        return solid_angle * 4 * cos_o;
    }
    dvec3 half_vector(Side side, const dvec3& wi) const {
        const dvec3 h =
            side == Side::Refracted ? wo + eta * wi : wo + (side == Side::Mirrored ? dvec3(wi.x, wi.y, -wi.z) : wi);
        return glm::normalize(h.z < 0 ? -h : h);
    }
};

/// Integrals over the cells of a grid in (q, turn): of the density and of f |cos| in Importance mode (so that a
/// refraction without loss integrates to 1).
struct CellIntegrals {
    std::vector<double> pdf;
    dvec3 f_cos{0};

    double total_pdf() const {
        double sum = 0;
        for (const double x : pdf) sum += x;
        return sum;
    }
};

struct CellGrid {
    int radial;
    int azimuths;
    int steps;  // quadrature points along a cell's edge

    size_t cell(const HalfVectorMap& map, const dvec3& h) const {
        const auto index = [](double x, int n) { return std::clamp(static_cast<int>(x * n), 0, n - 1); };
        return static_cast<size_t>(index(map.q(h), radial) * azimuths + index(HalfVectorMap::turn(h), azimuths));
    }
    size_t cells() const { return static_cast<size_t>(radial * azimuths); }
};

/// `evaluate(span of wi)`: their BsdfValues in Importance mode.
template <class Evaluate>
CellIntegrals integrate_values(const Evaluate& evaluate, const ScatteringMap& map, Side side, const CellGrid& grid) {
    struct Point {
        size_t cell;
        double solid_angle;
    };
    const int rows = grid.radial * grid.steps, columns = grid.azimuths * grid.steps;
    std::vector<vec3> directions;
    std::vector<Point> points;
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j) {
            dvec3 wi(0);
            const double solid_angle = map.scatter(side, (i + 0.5) / rows, (j + 0.5) / columns, wi) / rows / columns;
            if (solid_angle <= 0) continue;
            directions.emplace_back(wi);
            points.push_back({static_cast<size_t>(i / grid.steps * grid.azimuths + j / grid.steps), solid_angle});
        }
    CellIntegrals integrals;
    integrals.pdf.assign(grid.cells(), 0);
    const std::vector<BsdfValue> values = evaluate(std::span<const vec3>(directions));
    for (size_t i = 0; i < points.size(); ++i) {
        integrals.pdf[points[i].cell] += static_cast<double>(values[i].pdf_sa) * points[i].solid_angle;
        integrals.f_cos += dvec3(values[i].f_cos) * points[i].solid_angle;
    }
    return integrals;
}

inline CellIntegrals integrate_bsdf(const Bsdf& bsdf, const ScatteringMap& map, Side side, const CellGrid& grid) {
    const auto evaluate = [&](std::span<const vec3> directions) {
        std::vector<BsdfValue> values;
        values.reserve(directions.size());
        for (const vec3& wi : directions) values.push_back(bsdf.evaluate(vec3(map.wo), wi, TransportMode::Importance));
        return values;
    };
    return integrate_values(evaluate, map, side, grid);
}

inline dvec3 direction_at(double cos_theta, double turn) {
    const double r = std::sqrt(1 - cos_theta * cos_theta);
    return {r * std::cos(2 * M_PI * turn), r * std::sin(2 * M_PI * turn), cos_theta};
}

}  // namespace photond::test
