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

/// 256 bits, unsigned, in units of 2^-128: a FixedSum's square with nothing cut off, and sums of those.
struct WideSquares {
    FixedSquares high = 0, low = 0;

    WideSquares& operator+=(WideSquares more) {
        low += more.low;
        high += more.high + (low < more.low ? 1 : 0);
        return *this;
    }
    bool operator==(const WideSquares&) const = default;
};

inline WideSquares exact_square(FixedSum sum) {
    const auto multiply = [](uint64_t a, uint64_t b) { return FixedSquares{a} * b; };
    const FixedSquares magnitude = sum < 0 ? -static_cast<FixedSquares>(sum) : static_cast<FixedSquares>(sum);
    const uint64_t lo = static_cast<uint64_t>(magnitude), hi = static_cast<uint64_t>(magnitude >> 64);
    const FixedSquares cross = multiply(lo, hi);  // (hi 2^64 + lo)^2 = hi^2 2^128 + 2 cross 2^64 + lo^2
    WideSquares square{multiply(hi, hi) + (cross >> 63), multiply(lo, lo)};
    return square += WideSquares{0, cross << 65};
}

/// n x squares; the product must fit.
inline WideSquares times(FixedSquares squares, uint32_t n) {
    const FixedSquares low = FixedSquares{static_cast<uint64_t>(squares)} * n;
    const FixedSquares high = FixedSquares{static_cast<uint64_t>(squares >> 64)} * n + (low >> 64);
    return {high >> 64, high << 64 | static_cast<uint64_t>(low)};
}
inline WideSquares times(const WideSquares& squares, uint32_t n) {
    WideSquares product = times(squares.low, n);
    product.high += squares.high * n;
    return product;
}

/// Unbiased variance of n >= 2 values, from their sum and n times the sum of their squares:
/// (n sum x^2 - (sum x)^2) / (n (n-1)), the difference taken in whole numbers, so that n times the same has none.
inline double variance_of(FixedSum sum, const WideSquares& n_squares, uint32_t n) {
    const WideSquares square = exact_square(sum);
    // Squares that were cut can make the difference a little negative: that is 0.
    if (n_squares.high < square.high || (n_squares.high == square.high && n_squares.low <= square.low)) return 0;
    const FixedSquares borrow = n_squares.low < square.low ? 1 : 0;
    const double difference =
        0x1p128 * nearest_double(n_squares.high - square.high - borrow) + nearest_double(n_squares.low - square.low);
    return 0x1p-128 * difference / (static_cast<double>(n) * (static_cast<double>(n) - 1.0));
}

}  // namespace photond
