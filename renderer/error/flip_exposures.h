#pragma once
#include <span>
#include <vector>

namespace photond {

/// The exposures [stops, rising] at which HDR-FLIP looks at a reference [Andersson et al. 2021]: from the
/// one that takes its largest luminance to 0.85 on the display, to the one that does so with its median; as many as
/// there are stops between them, rounded up, at least two, evenly spaced.
///
/// `reference`: scene-linear RGB, interleaved; values that are not finite or negative count as 0.
/// Where the paper is silent: of an even number of pixels the median is the mean of the middle two (as in the first
/// published implementations; later ones take the upper of the two). If the median is 0, that of the pixels above 0
/// takes its place; if there are none, the one exposure is 0. Luminances below the smallest normal float count as 0. A
/// range of no width is one exposure, not the same one twice.
std::vector<float> flip_exposures(std::span<const float> reference);

}  // namespace photond
