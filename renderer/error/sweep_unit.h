#pragma once
// What sweeps over pixels divide their values by, so that they can be multiplied as floats.

#include <cmath>

namespace photond {

/// A power of two near the images' mean: neither squares nor quotients of values so divided overflow or vanish, as far
/// as the values are within `limit` of it. A mean beyond what floats can square has no such unit: the limit is 0.
struct SweepUnit {
    double unit = 1;
    float inverse = 1, limit = 0;

    /// `mean`: 0 or above, or not finite.
    explicit SweepUnit(double mean) {
        if (!(mean > 0x1p-120 && mean < 0x1p120)) return;
        const int exponent = std::ilogb(mean);
        unit = std::ldexp(1.0, exponent);
        inverse = std::ldexp(1.0f, -exponent);
        limit = 0x1p30f;
    }
};

}  // namespace photond
