#pragma once
// The images that an independent renderer made of the diffuse Cornell box (tests/data/reference), and which of their
// pixels a test judges. Images are RGB, interleaved, row 0 at the top.

#include <vector>

#include "renderer/scene/scene.h"

namespace photond::test {

inline constexpr Size2 kReferenceSize{256, 256};
inline constexpr double kReferenceNoise = 2.7e-4;  // RMSE a pixel, tests/data/reference/README.md

/// "reference_256.exr", "direct_only_256.exr" or "indirect_one_bounce_256.exr".
std::vector<float> reference_image(const char* file);

/// A square image of `side` pixels, each the mean of its square of pixels: with the reference's box filter, what would
/// have been rendered at that size. `side` divides the image's side.
std::vector<float> reduced(const std::vector<float>& image, uint32_t side);

/// Which pixels are judged; all when empty.
using Mask = std::vector<uint8_t>;

/// Pixels of a square mask of `side` that stand for squares of pixels which all belong.
Mask reduced_mask(const Mask& mask, uint32_t side);

size_t count_of(const Mask& mask);
double masked_mean(const std::vector<float>& image, size_t channel, const Mask& mask);
/// Mean of squared differences over the mask's pixels and all channels.
double masked_mse(const std::vector<float>& image, const std::vector<float>& expected, const Mask& mask);

/// Standard deviation of a masked mean of the reference, as an image of `pixels` that were reduced from it.
double reference_noise_of_mean(const Mask& mask, size_t pixels);

/// The position layer of one pass: means over a pixel's samples; 0 where nothing was hit.
std::vector<float> positions_seen(const Scene& scene, Size2 size);

/// Distance [m] of each pixel's point from the nearest edge at which a surface ends or bends; 0 where nothing was hit.
std::vector<float> distances_to_edges(const Scene& scene, const std::vector<float>& positions);

/// Pixels whose points, and whose neighbours', lie farther than `distance` [m] from every such edge, and on one surface
/// (silhouettes are left out).
Mask far_from_edges(const Scene& scene, Size2 size, float distance);

}  // namespace photond::test
