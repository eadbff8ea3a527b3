#pragma once
// FLIP written down directly from its publications, slow and in double precision: the independent answer for tests of
// the fast one. Filters are two-dimensional sums, colours go through every published step.
//
// [Andersson et al. 2020] FLIP: A Difference Evaluator for Alternating Images. PACMCGIT 3(2).
// [Andersson et al. 2021] Visualizing Errors in Rendered High Dynamic Range Images. Eurographics short papers.

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <span>
#include <vector>

namespace photond::test::direct_flip {

using Color = std::array<double, 3>;
struct Image {
    int width, height;
    std::vector<Color> pixels;

    const Color& at(int x, int y) const {  // edges repeated
        return pixels[static_cast<size_t>(std::clamp(y, 0, height - 1) * width + std::clamp(x, 0, width - 1))];
    }
};

/// IEC 61966-2-1, to seven digits.
inline constexpr double kXyz[3][3] = {{0.4123908, 0.3575843, 0.1804808},  //
                                      {0.2126390, 0.7151687, 0.0721923},  //
                                      {0.0193308, 0.1191948, 0.9505322}};
inline Color white() {
    Color w{};
    for (size_t i = 0; i < 3; ++i) w[i] = kXyz[i][0] + kXyz[i][1] + kXyz[i][2];
    return w;
}
inline Color xyz_of(const Color& rgb) {
    Color xyz{};
    for (size_t i = 0; i < 3; ++i)
        for (size_t j = 0; j < 3; ++j) xyz[i] += kXyz[i][j] * rgb[j];
    return xyz;
}
/// Cramer's rule.
inline Color rgb_of(const Color& xyz) {
    const auto determinant = [](const double(&m)[3][3]) {
        return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
               m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    };
    Color rgb{};
    for (size_t j = 0; j < 3; ++j) {
        double replaced[3][3];
        for (size_t i = 0; i < 3; ++i)
            for (size_t k = 0; k < 3; ++k) replaced[i][k] = k == j ? xyz[i] : kXyz[i][k];
        rgb[j] = determinant(replaced) / determinant(kXyz);
    }
    return rgb;
}

inline Color ycxcz_of(const Color& rgb) {
    const Color xyz = xyz_of(rgb), w = white();
    const double x = xyz[0] / w[0], y = xyz[1] / w[1], z = xyz[2] / w[2];
    return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}
inline Color rgb_of_ycxcz(const Color& c) {
    const Color w = white();
    const double y = (c[0] + 16) / 116, x = y + c[1] / 500, z = y - c[2] / 200;
    return rgb_of({x * w[0], y * w[1], z * w[2]});
}
inline Color lab_of(const Color& rgb) {
    const Color xyz = xyz_of(rgb), w = white();
    const auto f = [](double t) {
        constexpr double kDelta = 6.0 / 29;
        return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29;
    };
    const double x = f(xyz[0] / w[0]), y = f(xyz[1] / w[1]), z = f(xyz[2] / w[2]);
    return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}
inline Color hunt(const Color& lab) { return {lab[0], 0.01 * lab[0] * lab[1], 0.01 * lab[0] * lab[2]}; }
inline double hyab(const Color& p, const Color& q) {
    return std::fabs(p[0] - q[0]) + std::hypot(p[1] - q[1], p[2] - q[2]);
}

/// A square kernel of weights at (x, y), |x|, |y| <= radius.
struct Kernel {
    int radius;
    std::vector<double> weights;

    Kernel(int r, const std::function<double(int, int)>& weight) : radius(r) {
        for (int y = -r; y <= r; ++y)
            for (int x = -r; x <= r; ++x) weights.push_back(weight(x, y));
    }
    double at(int x, int y) const { return weights[static_cast<size_t>((y + radius) * (2 * radius + 1) + x + radius)]; }
    double filter(const Image& image, size_t channel, int x, int y) const {
        double sum = 0;
        for (int dy = -radius; dy <= radius; ++dy)
            for (int dx = -radius; dx <= radius; ++dx) sum += at(dx, dy) * image.at(x + dx, y + dy)[channel];
        return sum;
    }
};

/// Contrast sensitivity of a channel: 0 achromatic, 1 red-green, 2 blue-yellow.
inline Kernel contrast_kernel(int channel, double pixels_per_degree) {
    using std::numbers::pi;
    constexpr double kA1[] = {1, 1, 34.1}, kB1[] = {0.0047, 0.0053, 0.04};
    constexpr double kA2[] = {0, 0, 13.5}, kB2[] = {1e-5, 1e-5, 0.025};
    const int radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * pi * pi)) * pixels_per_degree));
    Kernel kernel(radius, [&](int x, int y) {
        const double z = (x * x + y * y) / (pixels_per_degree * pixels_per_degree);
        return kA1[channel] * std::sqrt(pi / kB1[channel]) * std::exp(-pi * pi * z / kB1[channel]) +
               kA2[channel] * std::sqrt(pi / kB2[channel]) * std::exp(-pi * pi * z / kB2[channel]);
    });
    double sum = 0;
    for (const double w : kernel.weights) sum += w;
    for (double& w : kernel.weights) w /= sum;
    return kernel;
}

/// Edge (first derivative) or point (second derivative) detector, along x or along y.
inline Kernel feature_kernel(bool point, bool along_y, double pixels_per_degree) {
    const double deviation = 0.5 * 0.082 * pixels_per_degree;
    Kernel kernel(static_cast<int>(std::ceil(3 * deviation)), [&](int x, int y) {
        const double gaussian = std::exp(-(x * x + y * y) / (2 * deviation * deviation)), u = along_y ? y : x;
        return (point ? u * u / (deviation * deviation) - 1 : -u) * gaussian;
    });
    double positive = 0, negative = 0;
    for (const double w : kernel.weights) (w > 0 ? positive : negative) += w;
    for (double& w : kernel.weights) w /= w > 0 ? positive : -negative;
    return kernel;
}

inline double color_error(double distance) {
    constexpr double kQc = 0.7, kPc = 0.4, kPt = 0.95;
    const double largest = std::pow(hyab(hunt(lab_of({0, 1, 0})), hunt(lab_of({0, 0, 1}))), kQc);
    const double error = std::pow(distance, kQc), knee = kPc * largest;
    return error < knee ? kPt / knee * error : kPt + (error - knee) / (largest - knee) * (1 - kPt);
}

/// LDR-FLIP of two images in [0, 1].
inline std::vector<double> ldr(const Image& reference, const Image& test, double pixels_per_degree) {
    struct Kernels {
        std::vector<Kernel> contrast, edge, point;
    } kernels;
    for (int i = 0; i < 3; ++i) kernels.contrast.push_back(contrast_kernel(i, pixels_per_degree));
    for (const bool along_y : {false, true}) {
        kernels.edge.push_back(feature_kernel(false, along_y, pixels_per_degree));
        kernels.point.push_back(feature_kernel(true, along_y, pixels_per_degree));
    }
    const auto opponent = [](Image image) {
        for (Color& c : image.pixels) c = ycxcz_of(c);
        return image;
    };
    const auto luminance = [](Image image) {
        for (Color& c : image.pixels) c[0] = (c[0] + 16) / 116;
        return image;
    };
    const Image images[2] = {opponent(reference), opponent(test)};
    const Image grey[2] = {luminance(images[0]), luminance(images[1])};
    std::vector<double> map;
    for (int y = 0; y < reference.height; ++y)
        for (int x = 0; x < reference.width; ++x) {
            Color lab[2];
            double edge[2], point[2];
            for (size_t i = 0; i < 2; ++i) {
                Color filtered;
                for (size_t c = 0; c < 3; ++c) filtered[c] = kernels.contrast[c].filter(images[i], c, x, y);
                Color rgb = rgb_of_ycxcz(filtered);
                for (double& c : rgb) c = std::clamp(c, 0.0, 1.0);
                lab[i] = hunt(lab_of(rgb));
                edge[i] =
                    std::hypot(kernels.edge[0].filter(grey[i], 0, x, y), kernels.edge[1].filter(grey[i], 0, x, y));
                point[i] =
                    std::hypot(kernels.point[0].filter(grey[i], 0, x, y), kernels.point[1].filter(grey[i], 0, x, y));
            }
            const double feature =
                std::sqrt(std::max(std::fabs(edge[0] - edge[1]), std::fabs(point[0] - point[1])) / std::numbers::sqrt2);
            map.push_back(std::pow(color_error(hyab(lab[0], lab[1])), 1 - feature));
        }
    return map;
}

inline double aces(double x) {
    return std::clamp((0.9036 * x * x + 0.018 * x) / (0.8748 * x * x + 0.354 * x + 0.14), 0.0, 1.0);
}

inline std::vector<double> hdr(const Image& reference, const Image& test, std::span<const float> exposures,
                               double pixels_per_degree) {
    std::vector<double> largest(reference.pixels.size());
    for (const double exposure : exposures) {
        Image displayed[2] = {reference, test};
        for (Image& image : displayed)
            for (Color& c : image.pixels)
                for (double& value : c) value = aces(value * std::exp2(exposure));
        const std::vector<double> map = ldr(displayed[0], displayed[1], pixels_per_degree);
        for (size_t i = 0; i < map.size(); ++i) largest[i] = std::max(largest[i], map[i]);
    }
    return largest;
}

}  // namespace photond::test::direct_flip
