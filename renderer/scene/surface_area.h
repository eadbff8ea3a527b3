#pragma once
// How much surface a scene has.

namespace photond {

struct Scene;

/// Of all triangles of all instances, one side each [m^2].
double surface_area_m2(const Scene& scene);

}  // namespace photond
