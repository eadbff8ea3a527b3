#pragma once
// A filter that takes the noise of few paths out of an image within its surfaces: for pictures to recognise a scene by,
// never for a result.
//
// [Dammertz et al. 2010] Edge-Avoiding A-Trous Wavelet Transform for fast Global Illumination Filtering. HPG.
// [Schied et al. 2017] Spatiotemporal Variance-Guided Filtering. HPG (how far luminance may differ).

#include <span>

#include "renderer/core/rgb.h"

namespace photond {

/// What a pixel shows, each a pixel, row 0 at the top. Where nothing was met depth is 0 and nothing else is read.
struct FilterGuides {
    std::span<const Rgb> albedo;
    std::span<const vec3> normal;    // world space; a mean over samples, of any length
    std::span<const vec3> position;  // world space [m]
    std::span<const float> depth;    // [m]
};

/// Filters light that surfaces scatter, in place, but for the pattern of their albedo. Neighbours count by how near
/// they lie, by their normals, by their distance from the pixel's plane over its depth, and by how their luminance
/// differs, in standard deviations of what is about the pixel; after five steps light has come from up to 62 pixels
/// away. A pixel brighter than what is about it by more than two of them is first brought down to that: dots go, and
/// with them some energy. A pixel on an edge that found no neighbours takes the light of those that did.
///
/// Biased, and consistent in nothing: it blurs what light alone draws, shadows and caustics. Parallel over rows; the
/// same for any number of threads.
void filter_avoiding_edges(std::span<Rgb> light, Size2 size, const FilterGuides& guides);

}  // namespace photond
