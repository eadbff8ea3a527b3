#pragma once
// The edges at which surfaces end or turn away: what SurfaceBoundary looks up.

#include <vector>

#include "renderer/core/geometry.h"

namespace photond {

class Intersector;
struct Scene;

/// A half-edge of one triangle, or the edge between two across which a surface bends.
struct BoundaryEdge {
    vec3 a, b;    // world [m]; the triangle lies to the left of a -> b, seen from where its normal points
    vec3 normal;  // unit, by the winding
    /// Of a bend: the normal of the triangle to the right. Zero of a half-edge.
    vec3 other_normal;
    /// Distance along the normal, to either side, at which there is another surface just beyond the half-edge (the
    /// floor beyond the rim of a carpet) [m]; infinite when there is none within the radius, or one in the same plane.
    float continues_at_m;
};

/// Two triangles that share an edge are one surface when their normals, turned to the same side, agree within 60
/// degrees; what is left over at an edge are half-edges. Corners at equal world positions are the same corner, whatever
/// mesh or instance they belong to. Coincident triangles count once. Edges of smooth surfaces are kept, as bends, where
/// the surface turns so sharply that it may leave the cone of 60 degrees within a disc of `radius_m`: chamfers,
/// fillets. What lies beyond half-edges is asked of the scene's `intersector`: at most 16 rays for each piece of an
/// edge as long as the radius, so that masked texels are no surface. The result is the same for any number of threads;
/// the time is that of sorting the triangles' edges and of those rays.
std::vector<BoundaryEdge> find_boundary_edges(const Scene& scene, const Intersector& intersector, float radius_m);

/// How far float coordinates of the scene may be off [m].
float position_error_m(const Scene& scene);

}  // namespace photond
