#pragma once
// The geometry-aware box filter that takes out the pattern of interleaved sampling [Sun 2015, 4.12].
// GLSL twin: geometry_filter.glsl.
//
// [Laine et al. 2007] Incremental Instant Radiosity for Real-Time Indirect Illumination. EGSR.

#include <span>

#include "renderer/core/rgb.h"
#include "renderer/gbuffer/gbuffer_shared.h"
#include "renderer/gbuffer/geometry_filter_shared.h"
#include "renderer/gbuffer/split_buffer.h"

namespace photond {

using gpu::GeometryFilter;

/// For each Lambert point the mean of `irradiance` over its pixel and those about it that are Lambert points of the
/// same surface: pixels `x - width / 2` to `x - width / 2 + width - 1`, and so for y (an even width reaches one pixel
/// farther to the left and up), within the image. The same surface: the cosine between the normals that shade is at
/// least `normal_cosine`, and the neighbour is at most `distance_relative` times the pixel's depth from the plane
/// through the pixel's point, square to its geometric normal. Other points, padding too, keep what they have.
///
/// All spans are in the order of the split buffer and have layout.points() elements; `filtered` must not overlap.
/// Parallel over rows; the same for any number of threads.
void filter_geometry_aware(const SplitLayout& layout, std::span<const gpu::GBufferPoint> points,
                           std::span<const vec3> irradiance, const GeometryFilter& settings, std::span<vec3> filtered);

}  // namespace photond
