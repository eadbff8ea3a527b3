#pragma once
// Where to look at a closed room from that has no camera: from without nothing of it is lit.

#include <optional>

#include "renderer/scene/scene.h"

namespace photond {

/// A view of what the lamps light, from within, where light of the lamps does not leave the scene: fewer than one in
/// fifty of their rays meets nothing. It stands far back in the longest free way through the most open place that sees
/// a lamp. None where light leaves, an environment or a directional light shines on the outside, nothing shines, or the
/// scene has more than half a million triangles. Looks at every triangle some hundred times; the same for any number of
/// threads.
std::optional<Camera> find_inside_view(const Scene& scene);

}  // namespace photond
