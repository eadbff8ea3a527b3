#include "renderer/error/cross_meter.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>

#include "renderer/core/lanes.h"
#include "renderer/error/cross_sums.h"
#include "renderer/error/pixel_chunks.h"
#include "renderer/error/sweep_unit.h"

namespace photond {

namespace {

constexpr double kMostNoise = 1.0 / 300;  // relative variance of R, where it divides itself
constexpr double kMostBias = 0.1;         // of the half-width of a perfect image's interval, by the same
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
    CrossSums plain, relative;
    double shared_noise = 0;  // what D adds to `relative` where it has the pixel's own noise
    uint64_t count = 0;

    Sums& operator+=(const Sums& other) {
        plain += other.plain, relative += other.relative;
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
          shares_noise_(meter.denominators_ == Denominators::Pixel),
          inverse_(static_cast<float>(1 / meter.unit_)),
          limit_(std::min(SweepUnit(std::fabs(meter.mean_)).limit, kLimit)),
          square_(meter.unit_ * meter.unit_) {}

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
        FloatLanes plain = 0, relative = 0, shared_noise = 0;
        uint32_t blocks = 0;
    };
    /// d e / D or x y / D of a block's values, and the sums of their pixels' squares.
    struct Terms {
        std::array<float, kBlockValues> terms;
        float squares = 0;  // by pixel

        void keep(size_t v, const FloatLanes& value) { value.copy_to(&terms[v * kLanes], kUnaligned); }
        void end_block() {
            for (size_t i = 0; i < kBlockValues; i += 3) {
                const float pixel = terms[i] + terms[i + 1] + terms[i + 2];
                squares += pixel * pixel;
            }
        }
        double take() { return double{std::exchange(squares, 0.0f)}; }
    };

    /// In units, or of lanes of them; `weight` is 1 / D in them.
    template <class Value>
    static Value shared_noise(const Value& e, const Value& d, const Value& r, const Value& weight) {
        const Value nu = d * d * weight;
        return nu * weight * (Value(4) * e * r) - Value(2.0f / 3) * nu * nu * (Value(4) * r * r * weight - Value(1));
    }

    FloatLanes lanes_of(std::span<const float> values, size_t i) const {
        return FloatLanes(&values[i], kUnaligned) * inverse_;
    }

    void add_block(size_t first) {
        FloatLanes e[3], d[3], r[3];
        FloatMask usable(true);
        for (size_t v = 0; v < 3; ++v) {
            const size_t i = first + v * kLanes;
            r[v] = lanes_of(meter_.mean_reference_, i), d[v] = lanes_of(meter_.half_difference_, i);
            e[v] = lanes_of(image_, i) - r[v];
            usable = usable && abs(e[v]) < limit_ && abs(r[v]) < limit_ && abs(d[v]) < limit_;
        }
        if (!all_of(usable)) return add_values(first, first + kBlockValues);
        for (size_t v = 0; v < 3; ++v) {
            const FloatLanes weight(&meter_.weights_[first + v * kLanes], kUnaligned);
            const FloatLanes product = (e[v] - d[v]) * (e[v] + d[v]), term = d[v] * e[v];
            run_.plain += product, run_.relative += product * weight;
            if (shares_noise_) run_.shared_noise += shared_noise<FloatLanes>(e[v], d[v], r[v], weight);
            plain_.keep(v, term), relative_.keep(v, term * weight);
            plain_products_.keep(v, product), relative_products_.keep(v, product * weight);
        }
        for (Terms* terms : {&plain_, &relative_, &plain_products_, &relative_products_}) terms->end_block();
        if (++run_.blocks == kRun) end_run();
    }

    void end_run() {
        const double fourth = square_ * square_;
        sums_.plain += {total(run_.plain) * square_, 4 * plain_.take() * fourth, plain_products_.take() * fourth};
        sums_.relative += {total(run_.relative), 4 * relative_.take(), relative_products_.take()};
        sums_.shared_noise += total(run_.shared_noise);
        sums_.count += run_.blocks * kBlockValues;
        run_ = Run{};
    }

    /// [first, last), whole pixels.
    void add_values(size_t first, size_t last) {
        for (size_t pixel = first; pixel < last; pixel += 3) {
            double plain = 0, relative = 0, plain_product = 0, relative_product = 0;
            for (size_t i = pixel; i < pixel + 3; ++i) {
                const double r = double{meter_.mean_reference_[i]}, d = double{meter_.half_difference_[i]};
                const double e = double{image_[i]} - r, weight = double{meter_.weights_[i]} / square_;
                if (!std::isfinite(e) || !std::isfinite(d)) continue;
                const double product = (e - d) * (e + d), term = -2 * d * e;
                plain_product += product, plain += term;
                relative_product += product * weight, relative += term * weight;
                if (shares_noise_) sums_.shared_noise += shared_noise(e, d, r, weight);
                ++sums_.count;
            }
            sums_.plain += {plain_product, plain * plain, plain_product * plain_product};
            sums_.relative += {relative_product, relative * relative, relative_product * relative_product};
        }
    }

    const CrossMeter& meter_;
    const std::span<const float> image_;
    const bool shares_noise_;
    const float inverse_, limit_;
    const double square_;
    Run run_;
    Terms plain_, relative_, plain_products_, relative_products_;
    Sums sums_;
};

CrossMeter::CrossMeter(Size2 size, const std::vector<float>& u, const std::vector<float>& v)
    : size_(size),
      mean_reference_(half_of(u, v, 1)),
      half_difference_(half_of(u, v, -1)),
      weights_(mean_reference_.size()) {
    assert(u.size() == 3 * size_.pixels() && v.size() == u.size());
    double sum = 0;
    uint64_t count = 0;
    for (const float value : mean_reference_)
        if (std::isfinite(value)) sum += double{value}, ++count;
    mean_ = count > 0 ? sum / static_cast<double>(count) : 0;
    if (mean_ == 0) return;
    unit_ = SweepUnit(std::fabs(mean_)).unit;
    denominators_ = choose();
    for_each_chunk(weights_.size(), [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            const double b = denominators_ == Denominators::Pixel ? double{mean_reference_[i]} : mean_of_neighbours(i);
            const double weight = unit_ * unit_ / (b * b + 0.01 * mean_ * mean_);
            weights_[i] = std::isfinite(weight) ? static_cast<float>(weight) : 0.0f;
        }
    });
}

/// By the noise that U and V show: the mean of nu, of nu^3, and what the interval of a perfect image will be. Its
/// pixels' terms are twice the products of two independent noises, whose mean square is a third of that of d^2 where
/// channels share their noise, and less elsewhere.
Denominators CrossMeter::choose() const {
    struct Noise {
        double first = 0, third = 0, squared_terms = 0;
        uint64_t count = 0;

        Noise& operator+=(const Noise& other) {
            first += other.first, third += other.third, squared_terms += other.squared_terms, count += other.count;
            return *this;
        }
    };
    const double floor = 0.01 * mean_ * mean_;
    const Noise noise = sum_of_chunks<Noise>(size_.pixels(), [&](size_t first, size_t last) {
        Noise sums;
        for (size_t pixel = first; pixel < last; ++pixel) {
            double of_pixel = 0;
            for (size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) {
                const double r = double{mean_reference_[i]}, d = double{half_difference_[i]};
                if (!std::isfinite(r) || !std::isfinite(d)) continue;
                const double nu = d * d / (r * r + floor);
                sums.first += nu, sums.third += nu * nu * nu, of_pixel += nu, ++sums.count;
            }
            sums.squared_terms += 4.0 / 3 * of_pixel * of_pixel;
        }
        return sums;
    });
    const auto n = static_cast<double>(noise.count);
    const double half_width = kConfidenceZ * std::sqrt(noise.squared_terms) / n;
    const bool quiet = noise.first <= kMostNoise * n && 3 * noise.third / n <= kMostBias * half_width;
    return quiet ? Denominators::Pixel : Denominators::Neighbours;
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
    errors.denominators = denominators_;
    errors.left_out = image.size() - sums.count;
    if (sums.count == 0) return errors;
    errors.mse = sums.plain.error(sums.count, size_.pixels());
    if (mean_ == 0) return errors;
    errors.relative_mse = sums.relative.error(sums.count, size_.pixels());
    errors.relative_mse->value -= sums.shared_noise / static_cast<double>(sums.count);
    return errors;
}

}  // namespace photond
