#pragma once
#include <vector>

#include "renderer/scene/light.h"

namespace photond {

struct Scene;

/// Every triangle of every instance that sends out light: emissive, not unlit, of positive area and mean radiance. In
/// the order of instances, then triangles. Called by finish_scene().
std::vector<TriangleLight> find_triangle_lights(const Scene& scene);

}  // namespace photond
