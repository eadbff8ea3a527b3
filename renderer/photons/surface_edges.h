#pragma once
// The edges at which a surface does not go on straight: what EdgeTree holds.

#include "renderer/photons/edge_tree.h"

namespace photond {

struct Scene;

/// Edges of all triangles at which a surface ends, branches, bends by more than 60 degrees, or turns so sharply that it
/// may leave the cone of 60 degrees within a disc of `radius_m` (chamfers, fillets); smaller discs may not mind those.
/// Corners at equal world positions are the same corner, whatever mesh or instance they belong to. Coincident triangles
/// count once. The result is the same for any number of threads; the time is that of sorting the triangles' edges.
std::vector<SurfaceEdge> find_surface_edges(const Scene& scene, float radius_m);

/// How far float coordinates of the scene may be off [m].
float position_error_m(const Scene& scene);

}  // namespace photond
