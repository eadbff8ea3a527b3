#pragma once
// Light at fewer pixels than there are: of each block of n x n pixels one is lit, and the others take its light. What a
// pixel does is said in upsampling.glsl.

#include <cstdint>

#include "renderer/gbuffer/upsampling_shared.h"

namespace photond {

class ParamVisitor;

/// How a pixel takes light from the lit ones about it, where not all are lit. Each has the weights of those before.
enum class Upsampling : uint8_t {
    Nearest,
    Bilinear,  // by distance in the image
    Normal,    // by the normals' agreement
    Geometry,  // by the distance from the pixel's plane
};
static_assert(uint32_t(Upsampling::Nearest) == UPSAMPLING_NEAREST &&
              uint32_t(Upsampling::Bilinear) == UPSAMPLING_BILINEAR &&
              uint32_t(Upsampling::Normal) == UPSAMPLING_NORMAL &&
              uint32_t(Upsampling::Geometry) == UPSAMPLING_GEOMETRY);

/// `subsampling` (n: a power of two up to 8) and `upsampling`.
void visit_upsampling(ParamVisitor& visitor, uint32_t& subsampling, Upsampling& upsampling);

}  // namespace photond
