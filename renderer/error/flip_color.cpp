#include "renderer/error/flip_color.h"

#include <cmath>

#include "renderer/core/lane_math.h"
#include "renderer/error/white_relative_xyz.h"

namespace photond {

namespace {

/// Scalar product of the colour with row `plus` of the matrix, or with the difference of two rows: taken before
/// rounding, so that greys have next to no chroma.
template <size_t plus, int minus = -1>
FloatLanes row_times(const RgbLanes& c) {
    constexpr auto weight = [](size_t j) {
        return static_cast<float>(kXyzFromRgb[plus][j] -
                                  (minus < 0 ? 0 : kXyzFromRgb[static_cast<size_t>(minus & 3)][j]));
    };
    constexpr float kR = weight(0), kG = weight(1), kB = weight(2);
    return kR * c.r + kG * c.g + kB * c.b;
}

/// CIE 15: cube root, with a line near black.
FloatLanes lab_curve(const FloatLanes& t) {
    constexpr float kDelta = 6.0f / 29.0f;
    constexpr float kJoint = kDelta * kDelta * kDelta, kSlope = 1.0f / (3.0f * kDelta * kDelta);
    const FloatLanes above = std::experimental::max(t, FloatLanes(kJoint));
    return select(t > kJoint, cube_root(above), kSlope * t + 4.0f / 29.0f);
}

constexpr float kColorExponent = 0.7f;  // qc
constexpr float kKneeShare = 0.4f;      // pc: of the largest error
constexpr float kKneeError = 0.95f;     // pt: what it is mapped to

}  // namespace

[[gnu::flatten]] OpponentLanes opponent_from_rgb(const RgbLanes& rgb) {
    return {row_times<1>(rgb), row_times<0, 1>(rgb), row_times<1, 2>(rgb)};
}

[[gnu::flatten]] RgbLanes rgb_from_opponent(const OpponentLanes& opponent) {
    // X/Xn = y + cx, Z/Zn = y - cz; (1, 1, 1) is white in both spaces.
    const auto channel = [&](size_t i) {
        return opponent.y + static_cast<float>(kRgbFromXyz[i][0]) * opponent.cx -
               static_cast<float>(kRgbFromXyz[i][2]) * opponent.cz;
    };
    return {channel(0), channel(1), channel(2)};
}

[[gnu::flatten]] HuntLabLanes hunt_lab_from_rgb(const RgbLanes& rgb) {
    const FloatLanes fx = lab_curve(row_times<0>(rgb));
    const FloatLanes fy = lab_curve(row_times<1>(rgb));
    const FloatLanes fz = lab_curve(row_times<2>(rgb));
    const FloatLanes l = 116.0f * fy - 16.0f;
    const FloatLanes hunt = 0.01f * l;
    return {l, hunt * (500.0f * (fx - fy)), hunt * (200.0f * (fy - fz))};
}

[[gnu::flatten]] FloatLanes hyab(const HuntLabLanes& p, const HuntLabLanes& q) {
    const FloatLanes da = p.a - q.a, db = p.b - q.b;
    return std::experimental::abs(p.l - q.l) + std::experimental::sqrt(da * da + db * db);
}

float largest_hyab() {
    static const float largest = [] {
        const FloatLanes one = 1.0f, zero = 0.0f;
        const FloatLanes distance = hyab(hunt_lab_from_rgb({zero, one, zero}), hunt_lab_from_rgb({zero, zero, one}));
        return static_cast<float>(distance[0]);
    }();
    return largest;
}

[[gnu::flatten]] FloatLanes color_error(const FloatLanes& distance) {
    static const float largest = std::pow(largest_hyab(), kColorExponent);
    const float knee = kKneeShare * largest;
    const FloatLanes error = power(distance, kColorExponent);
    const FloatLanes low = error * (kKneeError / knee);
    const FloatLanes high = kKneeError + (error - knee) * ((1.0f - kKneeError) / (largest - knee));
    // The pair above is the largest up to rounding.
    return std::experimental::min(select(error < knee, low, high), FloatLanes(1.0f));
}

}  // namespace photond
