#pragma once
// Pixel reconstruction filters by importance sampling: where in the image a pixel's sample is taken, so that the mean
// of its samples is the filtered image and samples of different pixels never share a value.
// [Ernst, Stamminger, Greiner 2006] Filter Importance Sampling. IEEE Symposium on Interactive Ray Tracing.

#include <array>
#include <cmath>
#include <span>

#include "renderer/frame/render_context.h"

namespace photond {

class PixelFilterSampler {
public:
    static constexpr float kRadius = 1.5f;         // of the smooth filters [pixels]
    static constexpr float kGaussianSigma = 0.5f;  // [pixels]

    explicit PixelFilterSampler(PixelFilter filter) : filter_(filter) {
        if (filter == PixelFilter::Box) return;
        double sum = 0;
        for (size_t i = 0; i < kBins; ++i) {
            cdf_[i] = float(sum);
            sum += density(-kRadius + (float(i) + 0.5f) * kBinWidth);
        }
        for (float& c : cdf_) c = float(c / sum);
        cdf_[kBins] = 1;
    }

    /// Offset [pixels] from the pixel's top left corner; `u` uniform in [0,1)^2. Box: within the pixel.
    vec2 operator()(vec2 u) const {
        return filter_ == PixelFilter::Box ? u : vec2(0.5f) + vec2(invert(u.x), invert(u.y));
    }

    /// Whether a sample there, in pixels from the image's top left corner, can be one of any pixel.
    bool reaches_image(vec2 place, Size2 size) const {
        const float margin = filter_ == PixelFilter::Box ? 0.0f : kRadius - 0.5f;
        return place.x >= -margin && place.y >= -margin && place.x < static_cast<float>(size.width) + margin &&
               place.y < static_cast<float>(size.height) + margin;
    }
    /// Calls visit(pixel, density) for the pixels that draw samples there [1/pixel area].
    template <class Visit>
    void visit_pixels(vec2 place, Size2 size, const Visit& visit) const {
        const auto width = static_cast<int>(size.width), height = static_cast<int>(size.height);
        const auto pixel_of = [&](int x, int y) {
            return static_cast<uint32_t>(y) * size.width + static_cast<uint32_t>(x);
        };
        if (filter_ == PixelFilter::Box) {
            const int x = static_cast<int>(std::floor(place.x)), y = static_cast<int>(std::floor(place.y));
            if (x >= 0 && y >= 0 && x < width && y < height) visit(pixel_of(x, y), 1.0f);
            return;
        }
        const auto first = [](float p) { return std::max(static_cast<int>(std::ceil(p - 0.5f - kRadius)), 0); };
        const auto last = [](float p, int end) {
            return std::min(static_cast<int>(std::floor(p - 0.5f + kRadius)), end - 1);
        };
        for (int y = first(place.y); y <= last(place.y, height); ++y)
            for (int x = first(place.x); x <= last(place.x, width); ++x) {
                const float drawn = drawn_density(place.x - static_cast<float>(x) - 0.5f) *
                                    drawn_density(place.y - static_cast<float>(y) - 0.5f);
                if (drawn > 0) visit(pixel_of(x, y), drawn);
            }
    }

    static constexpr size_t kBins = 256;
    /// Of a smooth filter over its width, at the bins' edges; zeros for the box.
    std::span<const float, kBins + 1> cdf() const { return cdf_; }

private:
    static constexpr float kBinWidth = 2 * kRadius / float(kBins);

    /// The filter in one dimension, not normalised; the filters are separable.
    double density(float x) const {
        if (filter_ == PixelFilter::Gaussian) return std::exp(-0.5 * sqr(x / kGaussianSigma));
        // [Harris 1978] On the Use of Windows for Harmonic Analysis, four-term Blackman-Harris.
        const double phase = double(kPi) * (x / kRadius + 1);
        return 0.35875 - 0.48829 * std::cos(phase) + 0.14128 * std::cos(2 * phase) - 0.01168 * std::cos(3 * phase);
    }

    /// Of what invert() draws, constant over each bin [1/pixel].
    float drawn_density(float x) const {
        const float bin = (x + kRadius) / kBinWidth;
        if (!(bin >= 0 && bin < static_cast<float>(kBins))) return 0;
        const auto i = static_cast<size_t>(bin);
        return (cdf_[i + 1] - cdf_[i]) / kBinWidth;
    }

    float invert(float u) const {
        const auto above = std::upper_bound(cdf_.begin() + 1, cdf_.end() - 1, u);
        const float low = *(above - 1), high = *above;
        const float within = high > low ? (u - low) / (high - low) : 0.5f;
        return -kRadius + (float(above - 1 - cdf_.begin()) + within) * kBinWidth;
    }

    PixelFilter filter_;
    std::array<float, kBins + 1> cdf_{};
};

}  // namespace photond
