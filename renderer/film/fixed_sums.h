#pragma once
// Whole numbers of 128 bits, which a film's sums are: adding them loses nothing and knows no order.

#include <bit>
#include <cstdint>

namespace photond {

/// 128-bit signed fixed point with 64 fractional bits: range +-2^63, resolution 2^-64. A value of one pass lies below
/// kFilmValueLimit, so that 2^32 passes of three layers cannot overflow.
__extension__ typedef __int128 FixedSum;
/// Sums of squares, unsigned with 64 fractional bits. Addition saturates, which for values that are never negative is
/// still exactly associative; a saturated sum stands for "unknown" and its variance is infinite.
__extension__ typedef unsigned __int128 FixedSquares;

/// The double nearest to the number, ties to even, as a cast gives it: without the call into the compiler's library
/// that a cast of 128 bits is.
inline double nearest_double(FixedSquares number) {
    const auto high = static_cast<uint64_t>(number >> 64);
    if (high == 0) return static_cast<double>(static_cast<uint64_t>(number));
    const int unused_bits = std::countl_zero(high);
    const FixedSquares normalised = number << unused_bits;
    // 64 bits, of which a double takes 53: what lies below them matters to the rounding only by being there.
    const uint64_t leading = static_cast<uint64_t>(normalised >> 64) | (static_cast<uint64_t>(normalised) != 0);
    const double unit = std::bit_cast<double>(static_cast<uint64_t>(1023 + 64 - unused_bits) << 52);
    return unit * static_cast<double>(leading);
}

inline double nearest_double(FixedSum number) {
    return number < 0 ? -nearest_double(-static_cast<FixedSquares>(number))
                      : nearest_double(static_cast<FixedSquares>(number));
}

}  // namespace photond
