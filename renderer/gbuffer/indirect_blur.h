#pragma once
// Blur of a noisy layer across neighbouring pixels [Hoet 2014, 3.5 and 4.4]: a separable Gaussian, rows then columns.

#include <span>
#include <vector>

#include "renderer/core/rgb.h"

namespace photond {

/// What tells neighbouring pixels of different surfaces apart; empty spans: nothing does.
struct BlurEdges {
    std::span<const vec3> normal;  // unit, a pixel
    std::span<const float> depth;  // [m], a pixel; not finite: nothing was met
    float normal_power = 32;       // weights are max(0, n . n')^power
    float relative_depth = 0.02f;  // ... and exp(-((z - z') / (relative_depth z))^2)
};

/// Blurs `image` (row by row, as many pixels as `size` has) in place. `width` pixels across, odd: 3, 5, 7 or 9; its
/// standard deviation is width / 4. Weights are divided by their sum, at the image's border too: without edges the
/// image's mean is kept but for the border. Parallel over rows; the same for any number of threads.
void blur_layer(std::span<Rgb> image, Size2 size, uint32_t width, const BlurEdges& edges);

}  // namespace photond
