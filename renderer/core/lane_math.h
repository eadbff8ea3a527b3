#pragma once
// Roots and powers of several numbers at once, to float accuracy: for colour spaces, perceptual exponents, weights. The
// standard library's are called one number at a time.

#include "renderer/core/lanes.h"

namespace photond {

/// Cube root of normal numbers above 0; relative error below 3e-7. A guess from the exponent (within 4 %), then two
/// steps of Halley's method, each of which cubes the error.
inline FloatLanes cube_root(const FloatLanes& x) {
    constexpr int32_t kTwoThirdsOfBias = 0x2a50'8935;  // 127 * 2/3 in the exponent's place, less what halves the error
    const FloatLanes third = std::experimental::static_simd_cast<FloatLanes>(bits_of(x)) * (1.0f / 3.0f);
    FloatLanes root = float_from_bits(std::experimental::static_simd_cast<IntLanes>(third) + kTwoThirdsOfBias);
    for (int step = 0; step < 2; ++step) {
        const FloatLanes cube = root * root * root;
        root = root * ((cube + 2.0f * x) / (2.0f * cube + x));
    }
    return root;
}

/// Logarithm to base 2 of normal numbers above 0; error below 2e-7 + 1e-7 |log2 x|.
inline FloatLanes log2_lanes(const FloatLanes& x) {
    constexpr int32_t kSqrtHalfBits = 0x3f35'04f3;
    const IntLanes exponent = (bits_of(x) - kSqrtHalfBits) >> 23;
    const FloatLanes mantissa = float_from_bits(bits_of(x) - (exponent << 23));  // in [sqrt 1/2, sqrt 2)
    // ln m = 2 artanh((m - 1)/(m + 1)), as a series; what is left out is below 1e-9.
    const FloatLanes s = (mantissa - 1.0f) / (mantissa + 1.0f);
    const FloatLanes s2 = s * s;
    const FloatLanes series = s2 * (1.0f / 3 + s2 * (1.0f / 5 + s2 * (1.0f / 7 + s2 * (1.0f / 9))));
    constexpr float kTwoOverLn2 = 2.88539008177792681f;
    return std::experimental::static_simd_cast<FloatLanes>(exponent) + kTwoOverLn2 * (s + s * series);
}

/// 2^x of numbers up to 127; relative error below 3e-7, down to 2^-126, which stands for all below.
inline FloatLanes exp2_lanes(FloatLanes x) {
    constexpr float kRounder = 12582912.0f;  // 1.5 * 2^23: what is added to it is rounded to a whole number
    constexpr int32_t kRounderBits = 0x4b40'0000;
    x = std::experimental::max(x, FloatLanes(-126.0f));
    const FloatLanes shifted = x + kRounder;
    const IntLanes whole = bits_of(shifted) - kRounderBits;
    // 2^f = e^t as a Taylor series, |t| <= ln(2)/2; what is left out is below 6e-9.
    const FloatLanes t = (x - (shifted - kRounder)) * 0.693147180559945309f;
    FloatLanes series = 1.0f / 5040;
    for (const float inverse_factorial : {1.0f / 720, 1.0f / 120, 1.0f / 24, 1.0f / 6, 1.0f / 2, 1.0f, 1.0f})
        series = series * t + inverse_factorial;
    return series * float_from_bits((whole + 127) << 23);
}

/// x^p of x >= 0 and p > 0, with 0^p = 0 exactly; relative error below 1e-6 where |p log2 x| < 8.
inline FloatLanes power(const FloatLanes& x, const FloatLanes& p) {
    return select(x > 0.0f, exp2_lanes(p * log2_lanes(x)), 0.0f);
}

}  // namespace photond
