#pragma once
// What a surface sends out by itself. The one place that knows, for paths that hit a light and for the sampler of
// lights.

#include "renderer/core/rgb.h"

namespace photond {

struct Scene;

/// A point of a triangle: p = (1-u-v) p0 + u p1 + v p2.
struct SurfacePoint {
    uint32_t instance;
    uint32_t triangle;
    float u;
    float v;
};

/// Radiance [W m^-2 sr^-1] the material's emission sends from a point towards a direction on the given side of its
/// surface: factor x texture x strength; black at the back unless the material is double-sided. `front`: the direction
/// leaves on the side that the geometric normal points to (that of the corners' order, negated where the instance
/// mirrors). Black for unlit materials, which light nothing. Coverage (alpha) is not in it: a ray that hit met a
/// surface.
Rgb emitted_radiance(const Scene& scene, const SurfacePoint& point, bool front);

/// KHR_materials_unlit: the constant radiance [W m^-2 sr^-1] an unlit surface shows to the eye, directly, in mirrors
/// and through smooth glass, on both sides: base colour x texture x vertex colour. It belongs to the emitted layer of
/// camera paths that have met no non-delta vertex; to every other path, an unlit surface is black: it neither reflects
/// nor lights the scene. Black for materials that are not unlit.
Rgb unlit_radiance(const Scene& scene, const SurfacePoint& point);

/// Share of rays that meet the surface at this point: 1, masked texels 0, blended ones their alpha. Light drawn from a
/// point of a light is multiplied by it.
float surface_coverage(const Scene& scene, const SurfacePoint& point);

}  // namespace photond
