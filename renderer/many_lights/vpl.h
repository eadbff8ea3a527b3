#pragma once
// What virtual point lights send, whatever they light.

#include <numbers>

#include "renderer/core/rgb.h"
#include "renderer/many_lights/vpl_shared.h"

namespace photond {

using gpu::Vpl;

inline bool is_lambert(const Vpl& vpl) { return vpl.surface == NO_VPL_SURFACE; }

/// 1 / max(B, d^2): the clamp of connections; B = 0 for none (derivations.md, "The VPL clamp and its exact repayment").
/// What is at no distance at all is left out: 0.
inline float clamped_falloff(float distance_sq_m2, float clamp_sq_m2) {
    const float divisor = std::max(distance_sq_m2, clamp_sq_m2);
    return divisor > 0 ? 1 / divisor : 0.0f;
}

/// Where the shadow ray of a connection ends, over its length: it reaches a surface there, and the distance at which it
/// meets it is rounded. Where coordinates are 0 the end is hardly moved off the surface (offset_ray_origin()), however
/// large the scene is.
inline constexpr float kConnectionEnd = 1 - 0x1p-18f;

/// Default B [m^2] of `vpls` lights spread over `lit_area_m2` (methods.md, "svo_many_lights").
inline float default_clamp_sq_m2(float lit_area_m2, uint32_t vpls) {
    return lit_area_m2 / (std::numbers::pi_v<float> * static_cast<float>(std::max(vpls, 1u)));
}

}  // namespace photond
