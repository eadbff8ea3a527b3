#pragma once
// FLIP: how different two images look when one alternates between them.
//
// [Andersson et al. 2020] FLIP: A Difference Evaluator for Alternating Images. PACMCGIT 3(2).
// [Andersson et al. 2021] Visualizing Errors in Rendered High Dynamic Range Images. Eurographics short papers. (HDR)

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "renderer/core/geometry.h"

namespace photond {

/// The version of the definition that flip.cpp implements, stated with every figure.
inline constexpr const char* kFlipVersion = "FLIP 2020 (LDR), 2021 (HDR)";
/// A 0.7 m wide screen of 3840 pixels seen from 0.7 m: [Andersson et al. 2020, Sec. 6].
inline constexpr float kFlipPixelsPerDegree = 67.0206f;

/// Features of the reference are kept below this many bytes: 20 a pixel (rows padded to whole vectors) and exposure.
/// The exposures that do not fit are computed anew by each measurement, from a copy of the reference. A measurement
/// needs 4 bytes a pixel for its map and, on each thread, about 600 for each column.
inline constexpr uint64_t kFlipCacheBytes = uint64_t{256} << 20;

/// How far a pixel's value and a map's mean may be from the definition in exact arithmetic: single precision, largest
/// where features hardly differ, whose difference goes through a square root.
inline constexpr double kFlipLargestError = 2e-4, kFlipMeanError = 1e-5;

struct FlipMap {
    std::vector<float> values;  // one a pixel, 0 to 1, row 0 at the top
    double mean = 0;            // the pooled value
};

/// Pooling of a map [Andersson et al. 2020, Sec. 5]: the mean, and percentiles of the values weighted by themselves.
struct FlipPool {
    double mean = 0, weighted_first_quartile = 0, weighted_median = 0, weighted_third_quartile = 0;
    double minimum = 0, maximum = 0;
};
FlipPool pool_flip(std::span<const float> map);

enum class FlipRange : uint8_t {
    Ldr,  // scene-linear values clamped to [0, 1] and encoded as sRGB: what a display shows without exposure
    Hdr,  // over the exposures the reference asks for, tone-mapped (ACES), the largest LDR-FLIP of each pixel
};

/// FLIP against one reference, whose own filtered features are kept where they are not too large. Images are
/// scene-linear RGB, interleaved, row 0 at the top. Values that are not finite count as 0, negative ones as 0.
/// Thread-safe after construction.
class Flip {
public:
    /// `pixels_per_degree` >= 1. The result does not depend on `cache_bytes`, how much may be kept of the features.
    Flip(Size2 size, std::span<const float> reference, FlipRange range, float pixels_per_degree = kFlipPixelsPerDegree,
         uint64_t cache_bytes = kFlipCacheBytes);
    ~Flip();
    Flip(const Flip&) = delete;
    Flip& operator=(const Flip&) = delete;

    FlipMap measure(std::span<const float> image) const;
    /// Exposures [stops] of the HDR form, rising; {0} for the LDR form.
    const std::vector<float>& exposures() const;
    /// What it keeps: at most cache_bytes, and 12 a pixel where these are not enough.
    uint64_t bytes() const;

private:
    struct Impl;
    std::unique_ptr<const Impl> impl_;
};

}  // namespace photond
