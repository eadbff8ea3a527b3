// ErrorMeter::pointwise(): all measures that are sums over values, in one sweep.

#include <cassert>
#include <cmath>

#include "renderer/core/srgb_lanes.h"
#include "renderer/error/error_meter.h"
#include "renderer/error/pixel_chunks.h"

namespace photond {

namespace {

// Differences, squares and quotients are taken in double: no value that is a finite float can overflow or vanish in
// them, whatever the image's scale.
using DoubleLanes = std::experimental::rebind_simd_t<double, FloatLanes>;
constexpr std::experimental::element_aligned_tag kUnaligned;
constexpr double kDisplayWhite = 255;

/// static_simd_cast, of which GCC 12 thinks that it reads something uninitialised (GCC bug 105593).
DoubleLanes to_double(const FloatLanes& x) {
    using FloatVector [[gnu::vector_size(kLanes * sizeof(float))]] = float;
    using DoubleVector [[gnu::vector_size(kLanes * sizeof(double))]] = double;
    static_assert(sizeof(FloatVector) == sizeof(FloatLanes) && sizeof(DoubleVector) == sizeof(DoubleLanes));
    FloatVector floats;
    __builtin_memcpy(&floats, static_cast<const void*>(&x), sizeof x);
    const auto doubles = __builtin_convertvector(floats, DoubleVector);
    DoubleLanes result;
    __builtin_memcpy(static_cast<void*>(&result), &doubles, sizeof result);
    return result;
}

/// Of the values that are finite in both images.
struct Sums {
    double relative_squares = 0, squares = 0, absolutes = 0, symmetric = 0;
    std::array<double, 3> differences{}, encoded_squares{};  // by channel, as is
    std::array<uint64_t, 3> count{};

    Sums& operator+=(const Sums& other) {
        relative_squares += other.relative_squares, squares += other.squares;
        absolutes += other.absolutes, symmetric += other.symmetric;
        for (size_t k = 0; k < 3; ++k) {
            differences[k] += other.differences[k], encoded_squares[k] += other.encoded_squares[k];
            count[k] += other.count[k];
        }
        return *this;
    }
};

/// What keeps the relative measures finite where r is 0; both above 0.
struct Floors {
    double square;     // 0.01 m^2
    double magnitude;  // 0.1 m
};

/// Adds up blocks of kLanes pixels. Three vectors hold such a block; the channel of lane l of vector v is (v kLanes +
/// l) mod 3, the same in every block, so that sums by channel are taken apart only at the end.
class Sweep {
public:
    static constexpr size_t kBlockValues = 3 * kLanes;

    explicit Sweep(const Floors& floors) : floors_(floors) {}

    void add_block(const float* image, const float* reference, const float* encoded_reference) {
        FloatMask finite[3];
#pragma GCC unroll 3
        for (size_t v = 0; v < 3; ++v)
            finite[v] = add_vector(v, FloatLanes(image + v * kLanes, kUnaligned),
                                   FloatLanes(reference + v * kLanes, kUnaligned),
                                   FloatLanes(encoded_reference + v * kLanes, kUnaligned));
        if (all_of(finite[0] && finite[1] && finite[2])) {
            whole_pixels_ += kLanes;
        } else {
            for (size_t i = 0; i < kBlockValues; ++i) count_[i % 3] += finite[i / kLanes][i % kLanes] ? 1 : 0;
        }
    }

    Sums sums() const {
        Sums result{.relative_squares = reduce(relative_squares_),
                    .squares = reduce(squares_),
                    .absolutes = reduce(absolutes_),
                    .symmetric = 2 * reduce(half_symmetric_),
                    .count = count_};
        for (size_t i = 0; i < kBlockValues; ++i) {
            result.differences[i % 3] += differences_[i / kLanes][i % kLanes];
            result.encoded_squares[i % 3] += encoded_squares_[i / kLanes][i % kLanes];
        }
        for (uint64_t& count : result.count) count += whole_pixels_;
        return result;
    }

private:
    /// Returns which lanes are finite in both; the others count as two zeros, which add nothing.
    FloatMask add_vector(size_t v, const FloatLanes& image, const FloatLanes& reference, const FloatLanes& encoded) {
        const FloatMask finite = abs(image) < kInfinity && abs(reference) < kInfinity;
        const FloatLanes image_or_0 = select(finite, image, 0.0f);
        const DoubleLanes x = to_double(image_or_0), r = to_double(select(finite, reference, 0.0f));
        const DoubleLanes difference = x - r, square = difference * difference, absolute = abs(difference);
        const DoubleLanes square_scale = r * r + floors_.square, scale = abs(x) + abs(r) + floors_.magnitude;
        const DoubleLanes inverse = 1.0 / (square_scale * scale);  // one division for two quotients
        relative_squares_ += square * scale * inverse;
        half_symmetric_ += absolute * square_scale * inverse;
        squares_ += square;
        absolutes_ += absolute;
        differences_[v] += difference;
        const FloatLanes shown = srgb_encode_clamped(image_or_0) - select(finite, encoded, 0.0f);
        encoded_squares_[v] += to_double(shown * shown);
        return finite;
    }

    const Floors floors_;
    DoubleLanes relative_squares_ = 0, squares_ = 0, absolutes_ = 0, half_symmetric_ = 0;
    DoubleLanes differences_[3]{0, 0, 0}, encoded_squares_[3]{0, 0, 0};
    uint64_t whole_pixels_ = 0;        // of blocks in which all is finite
    std::array<uint64_t, 3> count_{};  // values of the other blocks
};

/// Pixels [first, last).
Sums sweep(const float* image, const float* reference, const float* encoded, size_t first, size_t last,
           const Floors& floors) {
    Sweep sweep(floors);
    size_t i = 3 * first;
    for (; i + Sweep::kBlockValues <= 3 * last; i += Sweep::kBlockValues)
        sweep.add_block(image + i, reference + i, encoded + i);
    if (i < 3 * last) {  // the rest of the image, filled up with values that are left out
        std::array<float, Sweep::kBlockValues> padded_image, padded_reference{}, padded_encoded{};
        padded_image.fill(kInfinity);
        std::copy(image + i, image + 3 * last, padded_image.begin());
        std::copy(reference + i, reference + 3 * last, padded_reference.begin());
        std::copy(encoded + i, encoded + 3 * last, padded_encoded.begin());
        sweep.add_block(padded_image.data(), padded_reference.data(), padded_encoded.data());
    }
    return sweep.sums();
}

}  // namespace

PointwiseErrors ErrorMeter::pointwise(std::span<const float> image) const {
    assert(image.size() == reference_.size());
    const bool relative = mean_ != 0;  // else any floors will do: what they give is not used
    const Floors floors = relative ? Floors{0.01 * mean_ * mean_, 0.1 * std::fabs(mean_)} : Floors{1, 1};
    const Sums sums = sum_of_chunks<Sums>(size_.pixels(), [&](size_t first, size_t last) {
        return sweep(image.data(), reference_.data(), encoded_.data(), first, last, floors);
    });

    PointwiseErrors errors;
    const uint64_t count = sums.count[0] + sums.count[1] + sums.count[2];
    errors.left_out = image.size() - count;
    if (count == 0) return errors;
    const auto mean = [&](double sum) { return sum / static_cast<double>(count); };
    errors.rmse = std::sqrt(mean(sums.squares));
    errors.mae = mean(sums.absolutes);
    if (relative) errors.relative_mse = mean(sums.relative_squares), errors.smape = mean(sums.symmetric);
    double display_error = 0;
    for (size_t k = 0; k < 3; ++k) {
        const auto channel_count = static_cast<double>(sums.count[k]);
        display_error += kDisplayWhite * std::sqrt(sums.encoded_squares[k] / channel_count);
        if (sums.count[k] == 0) continue;
        errors.bias[k] = sums.differences[k] / channel_count;
        if (channel_means_[k] != 0) errors.relative_bias[k] = *errors.bias[k] / channel_means_[k];
    }
    if (sums.count[0] > 0 && sums.count[1] > 0 && sums.count[2] > 0) errors.rmse_8bit = display_error;
    return errors;
}

}  // namespace photond
