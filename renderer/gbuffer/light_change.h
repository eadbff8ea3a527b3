#pragma once
// How much a pass's own light is to count beside the history's, by how far the light has changed since.

#include <span>
#include <vector>

#include "renderer/gbuffer/reprojection.h"

namespace photond {

/// Of each pixel; what History has of the same name is that with this pass taken in.
struct LightChange {
    std::vector<float> own_share;  // of the pass's light in the pixel's, 0 to 1; 1 where there is no history
    std::vector<Rgb> near_light, near_step;
    std::vector<float> step_product, age;
};

/// The share w with which w times the pass's light and 1 - w times the history's are expected to be nearest to the
/// truth: w = (b^2 + r / n) / (b^2 + r / n + r), for a history of n frames, noise of variance r in the pass's pixel,
/// and light that has changed by b. All are looked for in a window about the pixel, over pixels with a history: b^2 is
/// the squared difference of the means of pass and history less what noise makes of it, and r follows from how the
/// differences vary within the window. Noise of the means is that of independent pixels, or else, where pixels share
/// theirs as they do virtual lights, what steps from frame to frame tell: a step that noise made is taken back by the
/// next, so that their product is less than 0 by that noise's variance, where light that goes on changing makes it
/// greater. Squares are summed over the channels. Pixels of the pass that are no numbers tell nothing. Parallel; the
/// same for any number of threads.
LightChange find_light_change(const Reprojected& found, std::span<const Rgb> indirect);

}  // namespace photond
