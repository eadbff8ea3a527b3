#pragma once
// From the eye through what is specular: a tile's paths together, vertex by vertex. At each vertex light samples are
// drawn for the whole BSDF, the specular part f_s (delta lobes, and glossy ones with alpha below the threshold) is
// followed, and where there is a rough part f_d a visible point is left, for a method to bring it what light was
// scattered before. Light samples and followed directions are joined by multiple importance sampling.

#include <functional>
#include <span>
#include <vector>

#include "renderer/methods/eye_contributions.h"
#include "renderer/methods/tiles.h"
#include "renderer/methods/visible_point.h"
#include "renderer/transport/lambert_lanes.h"

namespace photond {

/// What a method decides at each vertex. The defaults: one light sample, judged by a shadow ray, that competes with the
/// followed direction alone.
struct WalkVertex {
    uint32_t light_samples = 1;
    uint32_t competing_rays =
        0;  // other rays drawn by f_d that will meet lights: f_d's light samples are weighed by them
};

}  // namespace photond
