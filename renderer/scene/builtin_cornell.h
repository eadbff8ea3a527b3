#pragma once
// Parts of the measured Cornell box, for the scenes that furnish it otherwise.

#include "renderer/scene/scene.h"

namespace photond {

/// The room with its camera, without light and blocks. Material 0 is white; `floor_material`, where it has a name, is
/// the floor's.
Scene make_cornell_room(const Material& floor_material = {});
void add_cornell_tall_block(Scene& scene, uint32_t material);
/// The short block's mesh, where it stands in the room.
Mesh make_cornell_short_block(uint32_t material);

inline constexpr Rgb kCornellLightRadiance{17, 12, 4};

}  // namespace photond
