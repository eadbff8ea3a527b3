#pragma once
#include <cstdint>

namespace photond {

struct Scene;

/// Has solids of glass that share a face overlap there by a hair.
///
/// A ray that goes on from a surface starts a few roundings beside it (offset_ray_origin()) and never meets what lies
/// closer: where one block of glass lies on another, it meets one of the two faces, rounding says which, and does not
/// learn of the other. So the face of one block is moved into the other, farther than rays start off, and tapers off to
/// the sides so that it stays within. A ray then meets both, and MediumStack says which of them bends it.
///
/// Touching: two meshes of solids that each face the other, plane on plane, no farther apart than rays start off. A
/// mesh that is placed several times keeps its shape, and the scene warns, once, where neither of two can be changed.
/// Returns how many meshes changed: none when called again.
uint32_t overlap_touching_solids(Scene& scene);

}  // namespace photond
