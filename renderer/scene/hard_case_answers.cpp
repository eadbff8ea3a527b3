#include "renderer/scene/hard_case_answers.h"

#include <cassert>

namespace photond {

namespace {

constexpr double kPiD = 3.14159265358979323846;

/// Sum of term(x, y, xi, eta) over the corners of both rectangles, signed by their number, over the area of `from`.
template <class Term>
double corner_sum(const Rectangle& from, const Rectangle& to, const Term& term) {
    const double x[2] = {from.x0, from.x1}, y[2] = {from.y0, from.y1};
    const double xi[2] = {to.x0, to.x1}, eta[2] = {to.y0, to.y1};
    double sum = 0;
    for (int corner = 0; corner < 16; ++corner) {
        const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2 & 1, l = corner >> 3;
        sum += ((i + j + k + l) % 2 ? -1 : 1) * term(x[i], y[j], xi[l], eta[k]);
    }
    return sum / from.area();
}

/// x log(y), 0 where x is.
double x_log(double x, double y) { return x == 0 ? 0.0 : x * std::log(y); }

}  // namespace

double parallel_form_factor(const Rectangle& from, const Rectangle& to, double gap) {
    assert(gap > 0);
    return corner_sum(from, to, [gap](double x, double y, double xi, double eta) {
        const double a = x - xi, b = y - eta;
        const double p = std::hypot(a, gap), q = std::hypot(b, gap);
        return (b * p * std::atan(b / p) + a * q * std::atan(a / q) - 0.5 * gap * gap * std::log(a * a + q * q)) /
               (2 * kPiD);
    });
}

double perpendicular_form_factor(const Rectangle& from, const Rectangle& to) {
    return corner_sum(from, to, [](double x, double y, double xi, double eta) {
        const double c = std::hypot(x, xi), d = y - eta;
        return (d * c * std::atan2(d, c) - 0.25 * x_log((c - d) * (c + d), c * c + d * d)) / (2 * kPiD);
    });
}

double polygon_irradiance(const dvec3& point, const dvec3& normal, std::span<const dvec3> corners) {
    double sum = 0;
    for (size_t i = 0; i < corners.size(); ++i) {
        const dvec3 a = glm::normalize(corners[i] - point);
        const dvec3 b = glm::normalize(corners[(i + 1) % corners.size()] - point);
        const dvec3 across = glm::cross(a, b);
        const double sine = glm::length(across);
        if (sine > 0) sum += std::atan2(sine, glm::dot(a, b)) * glm::dot(normal, across) / sine;
    }
    return 0.5 * sum;
}

double triangle_solid_angle(const dvec3& a, const dvec3& b, const dvec3& c) {
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    const double volume = std::fabs(glm::dot(a, glm::cross(b, c)));
    const double base = la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb;
    return 2 * std::atan2(volume, base);
}

double ggx_directional_albedo(double roughness, double cos_o) {
    // Over half vectors as D(h) cos(theta_h) has them, tan^2(theta_h) = alpha^2 u / (1 - u): the albedo is the mean of
    // G2(o, i) (o . h) / (cos_o cos_h), the reflected direction i being above the surface. [Heitz 2014, Eqs. 99, 72]
    const double alpha = roughness * roughness;
    const double sin_o = std::sqrt(1 - cos_o * cos_o);
    const auto lambda = [alpha](double cosine) {
        const double tan_sq = 1 / (cosine * cosine) - 1;
        return 0.5 * (std::sqrt(1 + alpha * alpha * tan_sq) - 1);
    };
    constexpr int kSteps = 256;  // of each side; the midpoint rule, periodic in the angle about the normal
    double sum = 0;
    for (int a = 0; a < kSteps; ++a) {
        // u = 1 - (1 - t)^2: fine where half vectors graze, coarse where they stand.
        const double t = (a + 0.5) / kSteps, u = 1 - (1 - t) * (1 - t), weight = 2 * (1 - t);
        const double cos_h = 1 / std::sqrt(1 + alpha * alpha * u / (1 - u));
        const double sin_h = std::sqrt(1 - cos_h * cos_h);
        for (int b = 0; b < kSteps; ++b) {
            const double o_h = sin_o * sin_h * std::cos(kPiD * (b + 0.5) / kSteps) + cos_o * cos_h;
            const double cos_i = 2 * o_h * cos_h - cos_o;
            if (o_h <= 0 || cos_i <= 0) continue;
            sum += weight * o_h / (cos_o * cos_h * (1 + lambda(cos_o) + lambda(cos_i)));
        }
    }
    return sum / (double{kSteps} * kSteps);
}

}  // namespace photond
