#pragma once
// Lamps: what casts one shadow each, and what it looks like from afar, where its middle is and how wide it is. For
// shadows by the middle of a light alone, which are then blurred by how wide it is.

#include <vector>

#include "renderer/gbuffer/lamps_shared.h"

namespace photond {

struct Scene;

/// A lamp is what hangs together of an instance's emitting triangles (they share corners), or a punctual light. Places
/// of triangles count by the light they send out. Punctual lights are points; directional ones are nowhere.
struct Lamps {
    std::vector<gpu::LampShape> shapes;
    std::vector<uint32_t> words;  // as lamps_shared.h says
};
Lamps find_lamps(const Scene& scene);

}  // namespace photond
