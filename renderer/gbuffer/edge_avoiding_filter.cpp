#include "renderer/gbuffer/edge_avoiding_filter.h"

#include <array>
#include <cassert>
#include <cmath>
#include <vector>

#include "renderer/core/parallel.h"

namespace photond {

namespace {

constexpr int kSteps = 5;
constexpr size_t kRowGrain = 4;
constexpr float kLeastAlbedo = 0.02f;            // darker surfaces are divided by this
constexpr float kRelativePlaneDistance = 0.02f;  // at which a neighbour counts no more, over the depth
constexpr float kLeastCosine = 0.9f;             // whose power is 0.001
constexpr float kLuminanceDeviations = 4;        // by which luminance may differ [Schied et al. 2017, Eq. 5]
constexpr float kDotDeviations = 2;              // above the mean of what is about it a pixel is a dot
constexpr int kAboutRadius = 3;                  // of what tells a pixel's mean and variance
constexpr int kNearRadius = 2;                   // of those that an edge's pixel asks
constexpr float kTrustedWeight = 3;              // a pixel of this weight, its own being 1, needs nobody else
constexpr std::array<float, 3> kSpline{3.0f / 8, 1.0f / 4, 1.0f / 16};  // B3, by the distance

struct Pixel {
    vec3 normal{0};
    float depth = 0;
    vec3 position{0};
};

struct Light {
    Rgb color{0};
    float luminance = 0;
    float variance = 0;
};

/// exp(-x) for x >= 0, to some percent.
float falling(float x) { return 1 / (1 + x * (1 + x * (0.5f + x * (1.0f / 6)))); }

/// 0 to 1: whether two pixels show one surface.
float sameness(const Pixel& here, const Pixel& there) {
    const bool met = here.depth > 0, other_met = there.depth > 0;
    if (met != other_met) return 0;
    if (!met) return 1;
    float cosine = glm::dot(here.normal, there.normal);
    if (cosine < kLeastCosine) return 0;
    for (int k = 0; k < 6; ++k) cosine *= cosine;  // to the power 64
    const float height = glm::dot(here.normal, there.position - here.position) / (kRelativePlaneDistance * here.depth);
    const float flat = std::max(0.0f, 1 - height * height);
    return cosine * flat * flat;
}

class Filter {
public:
    Filter(Size2 size, const FilterGuides& guides) : width_(int(size.width)), height_(int(size.height)) {
        pixels_.resize(size.pixels());
        for (size_t i = 0; i < pixels_.size(); ++i) {
            if (!(guides.depth[i] > 0)) continue;
            const float length = glm::length(guides.normal[i]);
            pixels_[i] = {length > 0 ? guides.normal[i] / length : vec3(0), guides.depth[i], guides.position[i]};
        }
        weight_.assign(pixels_.size(), 1);
    }

    /// Mean and variance of what is about each pixel, and dots brought down to them.
    std::vector<Light> begin(std::span<const Rgb> light) const {
        std::vector<Light> in(light.size()), out(light.size());
        for (size_t i = 0; i < light.size(); ++i) in[i] = {light[i], luminance(light[i]), 0};
        each_pixel([&](int x, int y, size_t i) {
            float sum = 0, squares = 0, weights = 0;
            each_neighbour(x, y, kAboutRadius, 1, [&](size_t j, int, int) {
                const float weight = i == j ? 1 : sameness(pixels_[i], pixels_[j]);
                sum += weight * in[j].luminance;
                squares += weight * in[j].luminance * in[j].luminance;
                weights += weight;
            });
            const float mean = sum / weights, variance = std::max(0.0f, squares / weights - mean * mean);
            const float most = mean + kDotDeviations * std::sqrt(variance);
            const float scale = in[i].luminance > most ? most / in[i].luminance : 1;
            out[i] = {scale * in[i].color, scale * in[i].luminance, variance};
        });
        return out;
    }

    /// One step of the wavelets, whose taps lie `apart` pixels from each other.
    std::vector<Light> step(const std::vector<Light>& in, int apart) {
        std::vector<Light> out(in.size());
        each_pixel([&](int x, int y, size_t i) {
            const float tolerance = 1 / (kLuminanceDeviations * std::sqrt(variance_about(in, x, y)) + 1e-9f);
            Rgb color(0);
            float weights = 0, variance = 0;
            each_neighbour(x, y, 2, apart, [&](size_t j, int dx, int dy) {
                float weight = kSpline[size_t(std::abs(dx))] * kSpline[size_t(std::abs(dy))];
                if (i != j) {
                    const float same = sameness(pixels_[i], pixels_[j]);
                    if (same <= 0) return;
                    weight *= same * falling(tolerance * std::abs(in[i].luminance - in[j].luminance));
                }
                color += weight * in[j].color;
                variance += weight * weight * in[j].variance;
                weights += weight;
            });
            out[i].color = color / weights;
            out[i].luminance = luminance(out[i].color);
            out[i].variance = variance / (weights * weights);
            weight_[i] = std::max(weight_[i], weights / (kSpline[0] * kSpline[0]));
        });
        return out;
    }

    /// Pixels that stood alone take the light of those about them that did not.
    void lend_to_edges(const std::vector<Light>& filtered, std::span<Rgb> light) const {
        const auto trust = [this](size_t i) {
            return std::clamp((weight_[i] - 1) / (kTrustedWeight - 1), 1e-3f, 1.0f);
        };
        each_pixel([&](int x, int y, size_t i) {
            light[i] = filtered[i].color;
            const float own = trust(i);
            if (own >= 1) return;
            Rgb color(0);
            float weights = 0;
            each_neighbour(x, y, kNearRadius, 1, [&](size_t j, int dx, int dy) {
                if ((pixels_[i].depth > 0) != (pixels_[j].depth > 0)) return;
                const float weight = trust(j) * falling(0.5f * float(dx * dx + dy * dy));
                color += weight * filtered[j].color;
                weights += weight;
            });
            light[i] = own * light[i] + (1 - own) * color / weights;
        });
    }

private:
    template <class Visit>
    void each_pixel(const Visit& visit) const {
        parallel_for(size_t(height_), kRowGrain, [&](size_t y) {
            for (int x = 0; x < width_; ++x) visit(x, int(y), y * size_t(width_) + size_t(x));
        });
    }
    /// Those within the image, `apart` pixels from each other, up to `radius` steps away; the pixel itself too.
    template <class Visit>
    void each_neighbour(int x, int y, int radius, int apart, const Visit& visit) const {
        for (int dy = -radius; dy <= radius; ++dy) {
            const int v = y + dy * apart;
            if (v < 0 || v >= height_) continue;
            for (int dx = -radius; dx <= radius; ++dx) {
                const int u = x + dx * apart;
                if (u >= 0 && u < width_) visit(size_t(v) * size_t(width_) + size_t(u), dx, dy);
            }
        }
    }
    /// Its own is as noisy as the image.
    float variance_about(const std::vector<Light>& in, int x, int y) const {
        float sum = 0, weights = 0;
        each_neighbour(x, y, 1, 1, [&](size_t j, int dx, int dy) {
            const float weight = (dx == 0 ? 2.0f : 1.0f) * (dy == 0 ? 2.0f : 1.0f);
            sum += weight * in[j].variance;
            weights += weight;
        });
        return sum / weights;
    }

    const int width_, height_;
    std::vector<Pixel> pixels_;
    std::vector<float> weight_;  // that a pixel found at most, its own being 1
};

}  // namespace

void filter_avoiding_edges(std::span<Rgb> light, Size2 size, const FilterGuides& guides) {
    assert(light.size() == size.pixels() && guides.albedo.size() == light.size() && "one of each a pixel");
    assert(guides.normal.size() == light.size() && guides.position.size() == light.size());
    assert(guides.depth.size() == light.size());
    const auto reflectance = [&](size_t i) {
        return guides.depth[i] > 0 ? glm::max(guides.albedo[i], Rgb(kLeastAlbedo)) : Rgb(1);
    };
    for (size_t i = 0; i < light.size(); ++i) light[i] /= reflectance(i);
    Filter filter(size, guides);
    std::vector<Light> filtered = filter.begin(light);
    for (int k = 0; k < kSteps; ++k) filtered = filter.step(filtered, 1 << k);
    filter.lend_to_edges(filtered, light);
    for (size_t i = 0; i < light.size(); ++i) light[i] *= reflectance(i);
}

}  // namespace photond
