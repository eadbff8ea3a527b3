#pragma once
// Whether the light on a surface has changed since the frames before, told from noise.

#include <span>
#include <vector>

#include "renderer/gbuffer/reprojection.h"

namespace photond {

/// Of each pixel whose history was found.
struct LightChange {
    std::vector<float> kept;                  // share of the history's frames that still tell of the light, 0 to 1
    std::vector<Rgb> change, squared_change;  // as History has them, this pass taken in
};

/// About each pixel, in a window of 17 x 17, the pass's light is held to the history's, over pixels with one. Their
/// difference is noise of a known size: within the window, as if pixels were independent, or as in the passes before
/// (for lights that all pixels share the noise of), whichever is greater; few frames know little of that, and count
/// beside two of a quarter of the light. Where a single difference, or the running mean of some, is 2.5 standard
/// deviations off, less of the history is kept, and nothing from 4 on. Parallel; the same for any number of threads.
LightChange find_light_change(const Reprojected& found, std::span<const Rgb> indirect);

}  // namespace photond
