#pragma once
// Where the volumes lie that light propagates in.

#include "renderer/methods/light_propagation_volumes/propagation_shared.h"
#include "renderer/scene/camera.h"

namespace photond {

/// `cascades` grids of equal cells, 1 to PROPAGATION_MOST_CASCADES. The coarsest has the bounds in it and at least half
/// a cell about them; along their longest side it has `resolution` cells, at least 8, along others as few as that
/// takes. Each finer one has cells of half the size, as many of them, lies on its parent's cells, and holds what the
/// camera looks at: it reaches a quarter of its side behind the eye. Bounds of no extent, or none at all, get a grid
/// all the same. [Kaplanyan and Dachsbacher 2010, section 5]
gpu::PropagationCascades make_propagation_cascades(const Bounds3& bounds, const Camera& camera, uint32_t resolution,
                                                   uint32_t cascades);

}  // namespace photond
