// ErrorMeter::pointwise(): all measures that are sums over values, in one sweep.

#include <algorithm>
#include <cassert>
#include <cmath>

#include "renderer/core/srgb_lanes.h"
#include "renderer/error/error_meter.h"
#include "renderer/error/pixel_chunks.h"
#include "renderer/error/sweep_unit.h"

namespace photond {

namespace {

constexpr std::experimental::element_aligned_tag kUnaligned;
constexpr double kDisplayWhite = 255;

/// Weighted sums of products of x, r and d = x - r: what the least squares of s x - r over all factors s need.
template <class Sum>
struct Products {
    Sum dd = 0, xx = 0, xd = 0, xr = 0, rr = 0;

    /// Of one value, or of lanes, with its weight.
    void add(const Sum& x, const Sum& r, const Sum& d, const Sum& weight) {
        const Sum weighted_x = weight * x, weighted_r = weight * r;
        dd += weight * d * d, xx += weighted_x * x, xd += weighted_x * d, xr += weighted_x * r, rr += weighted_r * r;
    }
    template <class Other, class Map>
    void add(const Products<Other>& other, const Map& map) {
        dd += map(other.dd), xx += map(other.xx), xd += map(other.xd), xr += map(other.xr), rr += map(other.rr);
    }
};

struct Fit {
    double squares;                  // the least sum of (s x - r)^2
    std::optional<double> exposure;  // its s
};

/// sum (s x - r)^2 is least at s = xr / xx = 1 - xd / xx, where it is rr - xr^2 / xx = dd - xd^2 / xx. Of the two the
/// one that subtracts from less loses less: an image near the reference has small dd, one with a value beyond all
/// bounds, or far too bright, has it large.
Fit least_squares(const Products<double>& sums) {
    if (!(sums.xx > 0)) return {sums.rr, std::nullopt};
    if (sums.dd <= sums.rr) return {std::max(0.0, sums.dd - sums.xd / sums.xx * sums.xd), 1 - sums.xd / sums.xx};
    return {std::max(0.0, sums.rr - sums.xr / sums.xx * sums.xr), sums.xr / sums.xx};
}

/// Of the values that are finite in both images.
struct Sums {
    Products<double> plain, relative;  // weights 1 and 1 / (r^2 + 0.01 m^2)
    double absolutes = 0, symmetric = 0;
    std::array<double, 3> differences{}, encoded_squares{};  // by channel, as is
    std::array<uint64_t, 3> count{};

    Sums& operator+=(const Sums& other) {
        const auto same = [](double sum) { return sum; };
        plain.add(other.plain, same), relative.add(other.relative, same);
        absolutes += other.absolutes, symmetric += other.symmetric;
        for (size_t k = 0; k < 3; ++k) {
            differences[k] += other.differences[k], encoded_squares[k] += other.encoded_squares[k];
            count[k] += other.count[k];
        }
        return *this;
    }
};

/// Adds up blocks of kLanes pixels. Three vectors hold such a block; the channel of lane l of vector v is
/// (v kLanes + l) mod 3, the same in every block, so that sums by channel are taken apart only at the end.
///
/// Terms are floats, of values divided by a power of two near m, so that neither squares nor quotients overflow or
/// vanish; so are the sums of kRun blocks, which then go to sums in double. A block that holds a value out of that
/// range or not finite is added value by value in double.
class Sweep {
public:
    static constexpr size_t kBlockValues = 3 * kLanes;

    explicit Sweep(double mean)
        : mean_(std::fabs(mean)),
          unit_(mean_),
          square_floor_(static_cast<float>(square_floor() / (unit_.unit * unit_.unit))),
          magnitude_floor_(static_cast<float>(magnitude_floor() / unit_.unit)) {}

    void add_block(const float* image, const float* reference, const float* encoded_reference) {
        FloatLanes x[3], r[3];
        FloatMask usable(true);
        for (size_t v = 0; v < 3; ++v) {
            x[v] = FloatLanes(image + v * kLanes, kUnaligned) * unit_.inverse;
            r[v] = FloatLanes(reference + v * kLanes, kUnaligned) * unit_.inverse;
            usable = usable && abs(x[v]) < unit_.limit && abs(r[v]) < unit_.limit;
        }
        if (!all_of(usable)) return add_values(image, reference, encoded_reference, kBlockValues);
        for (size_t v = 0; v < 3; ++v) {
            add_differences(v, x[v], r[v]);
            const FloatLanes encoded = srgb_encode_clamped(FloatLanes(image + v * kLanes, kUnaligned));
            const FloatLanes shown = encoded - FloatLanes(encoded_reference + v * kLanes, kUnaligned);
            run_.encoded_squares[v] += shown * shown;
        }
        if (++run_.blocks == kRun) end_run();
    }

    /// `count` values, the first of channel R.
    void add_values(const float* image, const float* reference, const float* encoded_reference, size_t count) {
        for (size_t i = 0; i < count; ++i) {
            const double x = double{image[i]}, r = double{reference[i]};
            if (!std::isfinite(x) || !std::isfinite(r)) continue;
            const double difference = x - r, absolute = std::fabs(difference);
            const double shown = double{srgb_encode_clamped(image[i])[0]} - double{encoded_reference[i]};
            sums_.plain.add(x, r, difference, 1);
            sums_.absolutes += absolute;
            sums_.differences[i % 3] += difference;
            sums_.encoded_squares[i % 3] += shown * shown;
            ++sums_.count[i % 3];
            if (mean_ == 0) continue;
            sums_.relative.add(x, r, difference, 1 / (r * r + square_floor()));
            sums_.symmetric += 2 * absolute / (std::fabs(x) + std::fabs(r) + magnitude_floor());
        }
    }

    const Sums& finish() {
        end_run();
        return sums_;
    }

private:
    static constexpr uint32_t kRun = 32;

    struct Run {
        Products<FloatLanes> plain, relative;
        FloatLanes absolutes = 0, half_symmetric = 0;
        FloatLanes differences[3]{0, 0, 0}, encoded_squares[3]{0, 0, 0};
        uint32_t blocks = 0;
    };

    double square_floor() const { return 0.01 * mean_ * mean_; }
    double magnitude_floor() const { return 0.1 * mean_; }

    /// All in units of unit_.
    void add_differences(size_t v, const FloatLanes& x, const FloatLanes& r) {
        const FloatLanes difference = x - r, absolute = abs(difference);
        const FloatLanes square_scale = r * r + square_floor_, magnitude = abs(x) + abs(r) + magnitude_floor_;
        const FloatLanes inverse = 1.0f / (square_scale * magnitude);  // one division for two quotients
        run_.relative.add(x, r, difference, magnitude * inverse);
        run_.plain.add(x, r, difference, 1.0f);
        run_.half_symmetric += absolute * square_scale * inverse;
        run_.absolutes += absolute;
        run_.differences[v] += difference;
    }

    void end_run() {
        const auto sum = [](const FloatLanes& lanes) {
            double total = 0;
            for (size_t lane = 0; lane < kLanes; ++lane) total += double{lanes[lane]};
            return total;
        };
        sums_.relative.add(run_.relative, sum);
        sums_.plain.add(run_.plain, [&](const FloatLanes& lanes) { return sum(lanes) * unit_.unit * unit_.unit; });
        sums_.symmetric += 2 * sum(run_.half_symmetric);
        sums_.absolutes += sum(run_.absolutes) * unit_.unit;
        for (size_t i = 0; i < kBlockValues; ++i) {
            sums_.differences[i % 3] += double{run_.differences[i / kLanes][i % kLanes]} * unit_.unit;
            sums_.encoded_squares[i % 3] += double{run_.encoded_squares[i / kLanes][i % kLanes]};
        }
        for (uint64_t& count : sums_.count) count += run_.blocks * kLanes;
        run_ = Run{};
    }

    const double mean_;
    const SweepUnit unit_;  // without a limit all is added value by value
    const float square_floor_, magnitude_floor_;
    Run run_;
    Sums sums_;
};

/// Pixels [first, last).
Sums sweep(const float* image, const float* reference, const float* encoded, size_t first, size_t last, double mean) {
    Sweep sweep(mean);
    size_t i = 3 * first;
    for (; i + Sweep::kBlockValues <= 3 * last; i += Sweep::kBlockValues)
        sweep.add_block(image + i, reference + i, encoded + i);
    sweep.add_values(image + i, reference + i, encoded + i, 3 * last - i);
    return sweep.finish();
}

}  // namespace

PointwiseErrors ErrorMeter::pointwise(std::span<const float> image) const {
    assert(image.size() == reference_.size());
    const Sums sums = sum_of_chunks<Sums>(size_.pixels(), [&](size_t first, size_t last) {
        return sweep(image.data(), reference_.data(), encoded_.data(), first, last, mean_);
    });

    PointwiseErrors errors;
    const uint64_t count = sums.count[0] + sums.count[1] + sums.count[2];
    errors.left_out = image.size() - count;
    if (count == 0) return errors;
    const auto mean = [&](double sum) { return sum / static_cast<double>(count); };
    errors[Metric::Mse] = mean(sums.plain.dd);
    errors[Metric::Rmse] = std::sqrt(*errors[Metric::Mse]);
    const Fit fit = least_squares(sums.plain), relative_fit = least_squares(sums.relative);
    errors[Metric::FittedRmse] = std::sqrt(mean(fit.squares)), errors.least_squares_exposure = fit.exposure;
    errors[Metric::Mae] = mean(sums.absolutes);
    if (mean_ != 0) {
        errors[Metric::RelativeMse] = mean(sums.relative.dd), errors[Metric::Smape] = mean(sums.symmetric);
        errors[Metric::FittedRelativeMse] = mean(relative_fit.squares);
        errors.relative_least_squares_exposure = relative_fit.exposure;
    }
    double display_error = 0;
    for (size_t k = 0; k < 3; ++k) {
        const auto channel_count = static_cast<double>(sums.count[k]);
        display_error += kDisplayWhite * std::sqrt(sums.encoded_squares[k] / channel_count);
        if (sums.count[k] == 0) continue;
        errors.channels(Metric::Bias)[k] = sums.differences[k] / channel_count;
        if (channel_means_[k] != 0)
            errors.channels(Metric::RelativeBias)[k] = *errors.channels(Metric::Bias)[k] / channel_means_[k];
    }
    if (sums.count[0] > 0 && sums.count[1] > 0 && sums.count[2] > 0) errors[Metric::Rmse8bit] = display_error;
    return errors;
}

}  // namespace photond
