#include "renderer/error/cross_meter.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "renderer/error/pixel_chunks.h"

namespace photond {

namespace {

constexpr double kMostBias = 0.02;  // of what is measured, by denominators that share a pixel's noise
constexpr uint32_t kNeighbourhood = 2;

std::vector<float> mean_of(std::span<const float> u, std::span<const float> v) {
    std::vector<float> mean(u.size());
    for (size_t i = 0; i < mean.size(); ++i) mean[i] = static_cast<float>((double{u[i]} + double{v[i]}) / 2);
    return mean;
}

}  // namespace

bool is_quadratic(Metric metric) {
    return metric == Metric::Mse || metric == Metric::Rmse || metric == Metric::RelativeMse;
}

std::optional<CrossFigure> figure_of(const CrossErrors& errors, Metric metric) {
    assert(is_quadratic(metric));
    const std::optional<CrossError>& error = metric == Metric::RelativeMse ? errors.relative_mse : errors.mse;
    if (!error) return std::nullopt;
    const Interval interval = error->interval();
    if (metric == Metric::RelativeMse) return CrossFigure{error->value, interval, errors.denominators};
    if (metric == Metric::Mse) return CrossFigure{error->value, interval};
    const auto root = [](double square) { return std::sqrt(std::max(square, 0.0)); };
    CrossFigure figure{std::nullopt, {root(interval.least), root(interval.greatest)}};
    if (error->value >= 0) figure.value = root(error->value);
    return figure;
}

struct CrossMeter::Sums {
    double products = 0;       // x y / D
    double squared_terms = 0;  // q^2, by pixel
    double shared_noise = 0;   // of the bias that denominators leave which share the pixel's noise
    uint64_t count = 0;

    Sums& operator+=(const Sums& other) {
        products += other.products, squared_terms += other.squared_terms;
        shared_noise += other.shared_noise, count += other.count;
        return *this;
    }
    CrossError error() const {
        const auto n = static_cast<double>(count);
        return {products / n, std::sqrt(squared_terms) / n};
    }
};

CrossMeter::CrossMeter(Size2 size, std::vector<float> u, std::vector<float> v)
    : size_(size), u_(std::move(u)), v_(std::move(v)), mean_reference_(mean_of(u_, v_)) {
    assert(u_.size() == 3 * size_.pixels() && v_.size() == u_.size());
    double sum = 0;
    uint64_t count = 0;
    for (const float value : mean_reference_)
        if (std::isfinite(value)) sum += double{value}, ++count;
    const double mean = count > 0 ? sum / static_cast<double>(count) : 0;
    floor_ = 0.01 * mean * mean;
    neighbours_.resize(u_.size());
    for_each_chunk(neighbours_.size(), [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) neighbours_[i] = static_cast<float>(mean_of_neighbours(i));
    });
}

/// `square_of(value)` is b^2 + 0.01 m^2 of the value of that index.
template <class SquareOf>
CrossMeter::Sums CrossMeter::sums_of(std::span<const float> image, const SquareOf& square_of) const {
    return sum_of_chunks<Sums>(size_.pixels(), [&](size_t first, size_t last) {
        Sums sums;
        for (size_t pixel = first; pixel < last; ++pixel) {
            double term = 0;
            for (size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) {
                const double x = double{image[i]} - double{u_[i]}, y = double{image[i]} - double{v_[i]};
                if (!std::isfinite(x) || !std::isfinite(y)) continue;
                const double square = square_of(i);
                sums.products += x * y / square;
                term += (x - y) * (x + y) / (2 * square);
                const double nu = (x - y) * (x - y) / (4 * square);  // three nu^2 in the mean of its square
                sums.shared_noise += 2 * nu * nu + 2 * nu * (x + y) * double{mean_reference_[i]} / square;
                ++sums.count;
            }
            sums.squared_terms += term * term;
        }
        return sums;
    });
}

/// 0 where there is none.
double CrossMeter::mean_of_neighbours(size_t value) const {
    const auto pixel = static_cast<uint32_t>(value / 3);
    const uint32_t x = pixel % size_.width, y = pixel / size_.width;
    double sum = 0;
    uint32_t count = 0;
    const auto end = [](uint32_t at, uint32_t size) { return std::min(at + kNeighbourhood + 1, size); };
    for (uint32_t row = y - std::min(y, kNeighbourhood); row < end(y, size_.height); ++row)
        for (uint32_t column = x - std::min(x, kNeighbourhood); column < end(x, size_.width); ++column) {
            if (row == y && column == x) continue;
            const float neighbour = mean_reference_[3 * (size_t{row} * size_.width + column) + value % 3];
            if (std::isfinite(neighbour)) sum += double{neighbour}, ++count;
        }
    return count > 0 ? sum / count : 0;
}

CrossErrors CrossMeter::measure(std::span<const float> image) const {
    assert(image.size() == u_.size());
    CrossErrors errors;
    const Sums plain = sums_of(image, [](size_t) { return 1.0; });
    errors.left_out = image.size() - plain.count;
    if (plain.count == 0) return errors;
    errors.mse = plain.error();
    if (floor_ == 0) return errors;
    const auto divided_by = [&](std::span<const float> b) {
        return sums_of(image, [b, this](size_t i) { return double{b[i]} * double{b[i]} + floor_; });
    };
    const Sums by_pixel = divided_by(mean_reference_), by_neighbours = divided_by(neighbours_);
    const double measured = std::min(std::fabs(by_pixel.products), std::fabs(by_neighbours.products));
    const bool shared = std::fabs(by_pixel.shared_noise) > kMostBias * measured;
    errors.denominators = shared ? Denominators::Neighbours : Denominators::Pixel;
    errors.relative_mse = (shared ? by_neighbours : by_pixel).error();
    return errors;
}

}  // namespace photond
