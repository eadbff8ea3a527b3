#pragma once
// How many photons a scene stores, found out with a few light paths when the scene is judged: what a job with photons
// will hold is then known before it is queued.

#include <optional>

#include "renderer/frame/render_context.h"

namespace photond {

/// Nothing where no light leaves, and for scenes so large that a ray structure is not built just to ask.
std::optional<PhotonYield> measure_photon_yield(const Scene& scene);

}  // namespace photond
