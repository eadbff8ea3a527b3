#pragma once
#include <cstdint>

namespace photond {

struct Scene;

/// Makes every transmissive mesh whose surface is closed a solid that refracts and absorbs (a job's "glass": "solid"),
/// of an animated scene that of materials that transmit at some moment. The scene is to be at rest, and to be finished
/// again where meshes changed; animations drive the materials of solids as they drive those that these were made of.
/// Open ones stay thin sheets, and the scene warns of them with the number of their open edges. Brings the scene's
/// needs up to date. Returns how many meshes changed.
///
/// Closed: each edge is run through as often in one direction as in the other, once corners at equal positions are
/// welded and the ends of edges that are open even so are welded with what lies within kWeldDistance of them: seams and
/// poles of spheres end where sines and cosines were rounded to.
uint32_t make_closed_glass_solid(Scene& scene);

/// Within which ends of open edges are welded, of the radius of the mesh's bounding box.
inline constexpr float kWeldDistance = 1e-5f;

}  // namespace photond
