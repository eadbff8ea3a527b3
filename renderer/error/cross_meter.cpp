#include "renderer/error/cross_meter.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

#include "renderer/core/lanes.h"
#include "renderer/error/pixel_chunks.h"
#include "renderer/error/sweep_unit.h"

namespace photond {

namespace {

constexpr double kMostBias = 0.02;  // of what is measured, by denominators that share a pixel's noise
constexpr uint32_t kNeighbourhood = 2;

constexpr std::experimental::element_aligned_tag kUnaligned;

/// (u + sign v) / 2
std::vector<float> half_of(std::span<const float> u, std::span<const float> v, double sign) {
    std::vector<float> half(u.size());
    for (size_t i = 0; i < half.size(); ++i) half[i] = static_cast<float>((double{u[i]} + sign * double{v[i]}) / 2);
    return half;
}

double total(const FloatLanes& lanes) {
    double sum = 0;
    for (size_t lane = 0; lane < kLanes; ++lane) sum += double{lanes[lane]};
    return sum;
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
    /// Of terms divided by one kind of D.
    struct Divided {
        double products = 0;       // x y / D
        double squared_terms = 0;  // q^2, by pixel

        Divided& operator+=(const Divided& other) {
            products += other.products, squared_terms += other.squared_terms;
            return *this;
        }
        CrossError error(uint64_t count) const {
            const auto n = static_cast<double>(count);
            return {products / n, std::sqrt(squared_terms) / n};
        }
    };
    Divided plain, by_pixel, by_neighbours;  // D: 1, and b^2 + 0.01 m^2 for both kinds of b
    double shared_noise = 0;                 // of the bias that b = R leaves
    uint64_t count = 0;

    Sums& operator+=(const Sums& other) {
        plain += other.plain, by_pixel += other.by_pixel, by_neighbours += other.by_neighbours;
        shared_noise += other.shared_noise, count += other.count;
        return *this;
    }
};

/// Adds up blocks of kLanes pixels, as the sweep of pointwise() does: terms are floats, of values divided by a power of
/// two near m, and so are the sums of kRun blocks; a block that holds a value out of that range or not finite is added
/// value by value in double.
///
/// With e = A - R and d = (U - V) / 2: x = e - d, y = e + d, and q = -2 d e / D.
class CrossMeter::Sweep {
public:
    static constexpr size_t kBlockValues = 3 * kLanes;

    Sweep(const CrossMeter& meter, std::span<const float> image)
        : meter_(meter),
          image_(image),
          unit_(std::fabs(meter.mean_)),
          limit_(std::min(unit_.limit, kLimit)),
          floor_(0.01 * meter.mean_ * meter.mean_),
          scaled_floor_(static_cast<float>(floor_ / (unit_.unit * unit_.unit))) {}

    /// Pixels [first, last).
    Sums of(size_t first, size_t last) {
        size_t i = 3 * first;
        for (; i + kBlockValues <= 3 * last; i += kBlockValues) add_block(i);
        add_values(i, 3 * last);
        end_run();
        return sums_;
    }

private:
    static constexpr uint32_t kRun = 32;
    /// Of all values, in units: the sums hold their fourth powers over 0.01^2, which floats can up to 2^27.
    static constexpr float kLimit = 0x1p20f;

    struct Run {
        FloatLanes plain = 0, by_pixel = 0, by_neighbours = 0, shared_noise = 0;
        uint32_t blocks = 0;
    };
    /// d e / D of a block's values, and the sums of their pixels' squares.
    struct Terms {
        std::array<float, kBlockValues> terms;
        float squares = 0;

        void keep(size_t v, const FloatLanes& value) { value.copy_to(&terms[v * kLanes], kUnaligned); }
        void end_block() {
            for (size_t i = 0; i < kBlockValues; i += 3) {
                const float pixel = terms[i] + terms[i + 1] + terms[i + 2];
                squares += pixel * pixel;
            }
        }
        double take() { return 4 * double{std::exchange(squares, 0.0f)}; }
    };

    FloatLanes lanes_of(std::span<const float> values, size_t i) const {
        return FloatLanes(&values[i], kUnaligned) * unit_.inverse;
    }

    void add_block(size_t first) {
        FloatLanes e[3], d[3], r[3], b[3];
        FloatMask usable(true);
        for (size_t v = 0; v < 3; ++v) {
            const size_t i = first + v * kLanes;
            r[v] = lanes_of(meter_.mean_reference_, i), d[v] = lanes_of(meter_.half_difference_, i);
            b[v] = lanes_of(meter_.neighbours_, i), e[v] = lanes_of(image_, i) - r[v];
            usable = usable && abs(e[v]) < limit_ && abs(r[v]) < limit_ && abs(d[v]) < limit_ && abs(b[v]) < limit_;
        }
        if (!all_of(usable)) return add_values(first, first + kBlockValues);
        for (size_t v = 0; v < 3; ++v) {
            const FloatLanes product = (e[v] - d[v]) * (e[v] + d[v]), term = d[v] * e[v];
            const FloatLanes square = r[v] * r[v] + scaled_floor_, around = b[v] * b[v] + scaled_floor_;
            const FloatLanes inverse = 1.0f / (square * around);  // one division for two quotients
            const FloatLanes weight = around * inverse, weight_around = square * inverse;
            const FloatLanes nu = d[v] * d[v] * weight;
            run_.plain += product, run_.by_pixel += product * weight, run_.by_neighbours += product * weight_around;
            run_.shared_noise += nu * (2.0f * nu + 4.0f * e[v] * r[v] * weight);
            plain_.keep(v, term), by_pixel_.keep(v, term * weight), by_neighbours_.keep(v, term * weight_around);
        }
        plain_.end_block(), by_pixel_.end_block(), by_neighbours_.end_block();
        if (++run_.blocks == kRun) end_run();
    }

    void end_run() {
        const double square = unit_.unit * unit_.unit;
        sums_.plain += {total(run_.plain) * square, plain_.take() * square * square};
        sums_.by_pixel += {total(run_.by_pixel), by_pixel_.take()};
        sums_.by_neighbours += {total(run_.by_neighbours), by_neighbours_.take()};
        sums_.shared_noise += total(run_.shared_noise);
        sums_.count += run_.blocks * kBlockValues;
        run_ = Run{};
    }

    /// [first, last), whole pixels.
    void add_values(size_t first, size_t last) {
        for (size_t pixel = first; pixel < last; pixel += 3) {
            double plain = 0, by_pixel = 0, by_neighbours = 0;
            for (size_t i = pixel; i < pixel + 3; ++i) {
                const double r = double{meter_.mean_reference_[i]}, d = double{meter_.half_difference_[i]};
                const double e = double{image_[i]} - r, b = double{meter_.neighbours_[i]};
                if (!std::isfinite(e) || !std::isfinite(d)) continue;
                const double product = (e - d) * (e + d), term = -2 * d * e;
                sums_.plain.products += product, plain += term;
                ++sums_.count;
                if (floor_ == 0) continue;
                const double square = r * r + floor_, around = b * b + floor_, nu = d * d / square;
                sums_.by_pixel.products += product / square, by_pixel += term / square;
                sums_.by_neighbours.products += product / around, by_neighbours += term / around;
                // d^4 is three times its variance's square in the mean.
                sums_.shared_noise += nu * (2 * nu + 4 * e * r / square);
            }
            sums_.plain.squared_terms += plain * plain;
            sums_.by_pixel.squared_terms += by_pixel * by_pixel;
            sums_.by_neighbours.squared_terms += by_neighbours * by_neighbours;
        }
    }

    const CrossMeter& meter_;
    const std::span<const float> image_;
    const SweepUnit unit_;
    const float limit_;
    const double floor_;
    const float scaled_floor_;
    Run run_;
    Terms plain_, by_pixel_, by_neighbours_;
    Sums sums_;
};

CrossMeter::CrossMeter(Size2 size, const std::vector<float>& u, const std::vector<float>& v)
    : size_(size), mean_reference_(half_of(u, v, 1)), half_difference_(half_of(u, v, -1)) {
    assert(u.size() == 3 * size_.pixels() && v.size() == u.size());
    double sum = 0;
    uint64_t count = 0;
    for (const float value : mean_reference_)
        if (std::isfinite(value)) sum += double{value}, ++count;
    mean_ = count > 0 ? sum / static_cast<double>(count) : 0;
    neighbours_.resize(mean_reference_.size());
    for_each_chunk(neighbours_.size(), [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) neighbours_[i] = static_cast<float>(mean_of_neighbours(i));
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
    assert(image.size() == mean_reference_.size());
    const Sums sums = sum_of_chunks<Sums>(
        size_.pixels(), [&](size_t first, size_t last) { return Sweep(*this, image).of(first, last); });
    CrossErrors errors;
    errors.left_out = image.size() - sums.count;
    if (sums.count == 0) return errors;
    errors.mse = sums.plain.error(sums.count);
    if (mean_ == 0) return errors;
    const double measured = std::min(std::fabs(sums.by_pixel.products), std::fabs(sums.by_neighbours.products));
    const bool shared = std::fabs(sums.shared_noise) > kMostBias * measured;
    errors.denominators = shared ? Denominators::Neighbours : Denominators::Pixel;
    errors.relative_mse = (shared ? sums.by_neighbours : sums.by_pixel).error(sums.count);
    return errors;
}

}  // namespace photond
