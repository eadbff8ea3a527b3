#pragma once
// The colour spaces of FLIP: linear RGB, the opponent space its filters work in, Hunt-adjusted CIELAB, and distances
// there. [Andersson et al. 2020, Sec. 4.1]

#include "renderer/core/lanes.h"

namespace photond {

/// Scene-linear Rec.709 in [0, 1].
struct RgbLanes {
    FloatLanes r, g, b;
};

/// Zhang and Wandell's opponent space YCxCz, linear in RGB, without its scales and offset: it is (116 y - 16, 500 cx,
/// 200 cz). The filters are linear and keep constants, so these would cancel; and y is the (Y + 16)/116 that the
/// feature detectors take.
struct OpponentLanes {
    FloatLanes y;   // luminance, white 1
    FloatLanes cx;  // red-green: X/Xn - Y/Yn
    FloatLanes cz;  // blue-yellow: Y/Yn - Z/Zn
};
OpponentLanes opponent_from_rgb(const RgbLanes& rgb);
/// May leave [0, 1] for filtered colours.
RgbLanes rgb_from_opponent(const OpponentLanes& opponent);

/// CIELAB whose a and b are scaled by lightness / 100: the Hunt effect, colours are less vivid in the dark.
struct HuntLabLanes {
    FloatLanes l, a, b;
};
/// Of rgb in [0, 1]. Errors below 1e-4.
HuntLabLanes hunt_lab_from_rgb(const RgbLanes& rgb);

/// City-block in lightness, Euclidean in chroma [Abasi et al. 2020, Distance metrics for very large color differences].
FloatLanes hyab(const HuntLabLanes& p, const HuntLabLanes& q);

/// The HyAB distance of green and blue, taken as the largest of two displayed colours.
float largest_hyab();

/// HyAB distance (>= 0) to colour error in [0, 1]: raised to 0.7, then steep up to 0.4 of the largest, where it is
/// 0.95, and flat from there [Andersson et al. 2020, Sec. 4.1].
FloatLanes color_error(const FloatLanes& distance);

}  // namespace photond
