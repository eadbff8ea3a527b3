#pragma once
#include <cstdint>

namespace photond {

struct Scene;

/// Makes every transmissive mesh whose surface is closed a solid that refracts and absorbs (a job's "glass": "solid").
/// Open ones stay thin sheets. Closed: after welding corners at equal positions, each edge is run through as often in
/// one direction as in the other. Brings the scene's needs up to date. Returns how many meshes changed.
uint32_t make_closed_glass_solid(Scene& scene);

}  // namespace photond
