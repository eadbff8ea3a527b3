#pragma once
// A scene as points on its surfaces: what stands in for its triangles where each of many lights asks what it sees.

#include <vector>

#include "renderer/many_lights/imperfect_shadow_maps_shared.h"

namespace photond {

struct Scene;

/// `count` points on the scene's triangles, as evenly over their area as a sequence in their order makes it, with the
/// triangle's geometric normal (either side). The normal is 0, and the point is none, where a mask leaves no surface,
/// and by chance where blending leaves a part of one. Empty where there is no area. A pure function of its arguments.
std::vector<gpu::OccluderPoint> make_occluder_points(const Scene& scene, uint32_t count);

}  // namespace photond
