#pragma once
// The sRGB curve for whole images: several values at once, without calls of pow.

#include <bit>
#include <utility>

#include "renderer/core/lanes.h"
#include "renderer/core/srgb.h"

namespace photond {

namespace srgb_detail {

/// Horner's rule; coefficients from the constant term up.
template <size_t N>
FloatLanes polynomial(const float (&coefficients)[N], const FloatLanes& x) {
    FloatLanes sum = coefficients[N - 1];
    for (size_t i = N - 1; i-- > 0;) sum = sum * x + coefficients[i];
    return sum;
}

/// x^(1/2.4) for x in [2/3 * 2^-8, 1]. With x = 2^e m and m in [2/3, 4/3) it is 2^(5e/12) m^(5/12): the second by a
/// minimax polynomial in m - 1 (relative error 2.3e-8), the first, which has only the nine values e = -8 ... 0, by the
/// polynomial in e + 4 that goes through them.
inline FloatLanes power_5_12(const FloatLanes& x) {
    constexpr float kMantissa[] = {1.000000021f,  0.4166664471f,  -0.1215338021f,  0.06415932254f,
                                   -0.041156281f, 0.02919815271f, -0.02639268238f, 0.02258138133f};
    constexpr float kExponent[] = {0.3149802625f,   0.09096985988f,  0.01313656372f,  0.001264672987f, 9.131252845e-5f,
                                   5.271020092e-6f, 2.537871559e-7f, 1.084484266e-8f, 3.888152681e-10f};
    constexpr int32_t kTwoThirds = std::bit_cast<int32_t>(2.0f / 3.0f);
    const IntLanes bits = bits_of(x);
    const IntLanes exponent = (bits - kTwoThirds) >> 23;
    const FloatLanes mantissa = float_from_bits(bits - (exponent << 23));
    const FloatLanes e = std::experimental::static_simd_cast<FloatLanes>(exponent);
    return polynomial(kMantissa, mantissa - 1.0f) * polynomial(kExponent, e + 4.0f);
}

}  // namespace srgb_detail

/// srgb_encode() of values clamped to [0, 1], NaN as 0. Within 2.5e-7 of the exact curve (6e-5 of an 8-bit code).
inline FloatLanes srgb_encode_clamped(const FloatLanes& linear) {
    const FloatLanes low = select(linear > 0.0f, linear, 0.0f);
    const FloatLanes x = select(low < 1.0f, low, 1.0f);
    return select(x <= kSrgbLinearEnd, 12.92f * x, 1.055f * srgb_detail::power_5_12(x) - 0.055f);
}

}  // namespace photond
