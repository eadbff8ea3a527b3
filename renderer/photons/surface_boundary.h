#pragma once
// Where surfaces end, so that a disc of density estimation that hangs over an edge can be divided by the part of it
// that lies on the surface (photon_mapping's `boundary: "clip"`).
//
// A surface, here, is what photons are counted on: triangles whose normals agree within 60 degrees. The kernel's mass
// on it is the sum over its triangles of the kernel's integral over each, which by Green's theorem is a sum over
// oriented edges of angular integrals; edges shared by two triangles of the same surface cancel. What remains are the
// open edges and creases: only those are kept, and where none is near, the mass is 1. Seen from a point on the surface,
// the mass that a boundary cuts off is
//
//   1 - mass = sum over half-edges of the integral of +-(1 - M(rho(theta))) d theta / (2 pi),
//
// rho the distance at which the ray at angle theta meets the edge, M the kernel's mass within it, + where the point is
// on the edge's inner side, - where it is not (the far side of a hole). Edges that meet no corner to corner, but run
// along each other, cancel in this sum as well.
//
// The sum takes as long as there are edges near. Where they are crowded (DenseCells), a disc that meets too many of
// them is looked up on points spread over the surfaces beforehand instead (SurfaceSamples): the mass is then right to
// some ten percent. Elsewhere there are no such points, and all sums are exact.
//
// What it does not know: what hides a surface from photons (floor below a box that is not cut out of it counts as
// surface), and holes of alpha-masked textures. Both leave the mass too large, as without clipping.

#include <memory>

#include "renderer/core/memory_budget.h"
#include "renderer/photons/kernel.h"

namespace photond {

class Intersector;
struct Scene;

class SurfaceBoundary {
public:
    /// For discs of at most `radius_m`. World-space edges of all instances; corners at equal positions are welded.
    /// `intersector`, of the scene, is needed while this is built.
    SurfaceBoundary(const Scene& scene, const Intersector& intersector, float radius_m);
    ~SurfaceBoundary();
    SurfaceBoundary(SurfaceBoundary&&) noexcept;

    /// Share of the kernel's mass on the disc about p (on a surface; `normal` geometric, unit) that lies on surfaces
    /// whose photons would pass the disc test: within `thickness_m` of the tangent plane, normals within 60 degrees (of
    /// either side when an edge's triangles are seen from behind). In [kLeastMass, 1]. Where two sheets lie within
    /// `thickness_m`, an edge does not count if the other sheet goes on beyond it (a carpet's rim on a floor), and of
    /// the front and the back of a thin body only the nearer one's edges count. On an edge itself, to rounding, that
    /// edge does not count. Of crowded places the same to the noise of the points on them, but that one sheet above the
    /// other counts twice. The work is bounded, however many edges there are. `radius_m` at most that of the
    /// constructor.
    float mass_on_surface(const Kernel& kernel, const vec3& p, const vec3& normal, float radius_m,
                          float thickness_m) const;

    /// The divisor is not taken below this: a needle of surface would turn one photon into a firefly.
    static constexpr float kLeastMass = 0.1f;

    /// Edges near a cell as wide as two radii from which on points on surfaces stand in for exact sums. A disc holds a
    /// part of what is near its cell, and half of that faces another way, so that so few hardly ever fill more blocks
    /// (BoundaryTree::kMostBlocks) than an exact sum may visit.
    static constexpr size_t kDenseEdges = 4096;

    /// Edges kept: open ones, creases (one for each side), and sharp bends.
    size_t edges() const;
    /// Points on surfaces that masses are worked out with where edges are crowded; none where no place is.
    size_t samples() const;
    uint64_t bytes() const;

private:
    struct Edges;
    std::unique_ptr<const Edges> edges_;
};

}  // namespace photond
