#include "renderer/error/error_meter.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "renderer/core/srgb_lanes.h"
#include "renderer/error/pixel_chunks.h"

namespace photond {

namespace {

/// By channel: the sum of the finite values, and how many there are.
struct ChannelSums {
    std::array<double, 3> sum{};
    std::array<uint64_t, 3> count{};

    void add(const float* pixel) {
        for (size_t k = 0; k < 3; ++k)
            if (std::isfinite(pixel[k])) sum[k] += double{pixel[k]}, ++count[k];
    }
    ChannelSums& operator+=(const ChannelSums& other) {
        for (size_t k = 0; k < 3; ++k) sum[k] += other.sum[k], count[k] += other.count[k];
        return *this;
    }
};

ChannelSums channel_sums(std::span<const float> image) {
    return sum_of_chunks<ChannelSums>(image.size() / 3, [&](size_t first, size_t last) {
        ChannelSums sums;
        for (size_t pixel = first; pixel < last; ++pixel) sums.add(&image[3 * pixel]);
        return sums;
    });
}

std::vector<float> srgb_encoded(std::span<const float> image) {
    constexpr std::experimental::element_aligned_tag kUnaligned;
    std::vector<float> encoded(image.size());
    for_each_chunk(image.size(), [&](size_t first, size_t last) {
        size_t i = first;
        for (; i + kLanes <= last; i += kLanes)
            srgb_encode_clamped(FloatLanes(&image[i], kUnaligned)).copy_to(&encoded[i], kUnaligned);
        for (; i < last; ++i) encoded[i] = srgb_encode_clamped(image[i])[0];
    });
    return encoded;
}

/// Smallest of the values that at least `percent` percent of them do not exceed; those before `from`, which then moves
/// there, are known to be no larger.
double percentile(std::vector<double>& values, size_t percent, size_t& from) {
    const auto at = [&](size_t i) { return values.begin() + static_cast<std::ptrdiff_t>(i); };
    const size_t rank = (percent * values.size() + 99) / 100 - 1;
    std::nth_element(at(from), at(rank), values.end());
    from = rank;
    return values[rank];
}

/// Why pointwise() has no value for a metric.
std::string reason(const PointwiseErrors& errors, Metric metric) {
    for (size_t k = 0; k < 3; ++k)
        if (!errors.channels(Metric::Bias)[k]) return std::string("no finite values in channel ") + "RGB"[k];
    for (size_t k = 0; k < 3 && metric == Metric::RelativeBias; ++k)
        if (!errors.channels(Metric::RelativeBias)[k])
            return std::string("the mean of the reference is 0 in channel ") + "RGB"[k];
    return "the mean of the reference is 0";
}

}  // namespace

std::vector<double> PointwiseErrors::values_of(Metric metric) const {
    const MetricInfo& info = metric_info(metric);
    assert(!info.costly && "a metric of one sweep");
    std::vector<double> values;
    for (const std::optional<double>& value : std::span(channels(metric)).first(info.values)) {
        if (!value) return {};
        values.push_back(*value);
    }
    return values;
}

ErrorMeter::ErrorMeter(Size2 size, std::vector<float> reference)
    : size_(size), reference_(std::move(reference)), encoded_(srgb_encoded(reference_)) {
    assert(reference_.size() == 3 * size_.pixels());
    const ChannelSums sums = channel_sums(reference_);
    const uint64_t count = sums.count[0] + sums.count[1] + sums.count[2];
    if (count > 0) mean_ = (sums.sum[0] + sums.sum[1] + sums.sum[2]) / static_cast<double>(count);
    for (size_t k = 0; k < 3; ++k)
        if (sums.count[k] > 0) channel_means_[k] = sums.sum[k] / static_cast<double>(sums.count[k]);
}

ErrorMeter::~ErrorMeter() = default;

std::vector<double> ErrorMeter::relative_errors(std::span<const float> image) const {
    assert(image.size() == reference_.size());
    if (mean_ == 0) return {};
    const double floor = 0.01 * mean_ * mean_;
    std::vector<double> errors(size_.pixels());
    for_each_chunk(errors.size(), [&](size_t first, size_t last) {
        for (size_t pixel = first; pixel < last; ++pixel) {
            double sum = 0;
            for (size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) {
                const double x = double{image[i]}, r = double{reference_[i]};
                const bool finite = std::isfinite(x) && std::isfinite(r);
                sum += finite ? (x - r) * (x - r) / (r * r + floor) : std::numeric_limits<double>::quiet_NaN();
            }
            errors[pixel] = std::sqrt(sum / 3);
        }
    });
    return errors;
}

std::optional<std::array<double, 4>> ErrorMeter::percentiles(std::span<const float> image) const {
    std::vector<double> errors = relative_errors(image);
    std::erase_if(errors, [](double error) { return std::isnan(error); });
    if (errors.empty()) return std::nullopt;
    size_t from = 0;
    std::array<double, 4> result;
    for (size_t i = 0; i < result.size(); ++i) result[i] = percentile(errors, kPercentiles[i], from);
    return result;
}

const Flip& ErrorMeter::flip(std::unique_ptr<const Flip>& made, FlipRange range) const {
    const std::lock_guard lock(flip_mutex_);
    if (!made) made = std::make_unique<const Flip>(size_, reference_, range);
    return *made;
}

FlipMap ErrorMeter::flip_ldr(std::span<const float> image) const {
    assert(image.size() == reference_.size());
    return flip(flip_ldr_, FlipRange::Ldr).measure(image);
}

FlipMap ErrorMeter::flip_hdr(std::span<const float> image) const {
    assert(image.size() == reference_.size());
    return flip(flip_hdr_, FlipRange::Hdr).measure(image);
}

std::vector<double> ErrorMeter::measure(Metric metric, std::span<const float> image, std::string* why) const {
    assert(metric_info(metric).needs_reference);
    if (metric == Metric::FlipLdr) return {flip_ldr(image).mean};
    if (metric == Metric::FlipHdr) return {flip_hdr(image).mean};
    if (metric == Metric::FireflyCount) return {static_cast<double>(firefly_count(image))};
    if (metric == Metric::Percentiles) {
        if (const auto found = percentiles(image)) return {found->begin(), found->end()};
        if (why) *why = mean_ == 0 ? "the mean of the reference is 0" : "no pixel has finite values only";
        return {};
    }
    const PointwiseErrors errors = pointwise(image);
    std::vector<double> values = errors.values_of(metric);
    if (values.empty() && why) *why = reason(errors, metric);
    return values;
}

}  // namespace photond
