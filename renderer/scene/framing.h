#pragma once
// What a scene without cameras is framed on while an animation moves it.

#include <optional>

#include "renderer/scene/rig.h"

namespace photond {

/// A box around the scene at rest and at kFramedMoments moments of an animation, spread evenly from its start to its
/// last key: it does not depend on the moment that the scene shows, so that a camera framed on it stands still while
/// things move. What goes farther between these moments may leave the picture.
Bounds3 framing_bounds(const Scene& scene, const Rig& rig, uint32_t animation);
inline constexpr int kFramedMoments = 9;

}  // namespace photond
