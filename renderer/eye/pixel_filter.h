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
