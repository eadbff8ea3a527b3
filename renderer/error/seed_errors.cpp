#include "renderer/error/seed_errors.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

#include "renderer/error/pixel_chunks.h"
#include "renderer/error/student_t.h"

namespace photond {

namespace {

/// Sums over pixels, of values divided by one kind of D.
struct Sums {
    std::vector<double> products;  // of e_i e_j, by i and j <= i
    double shared_terms = 0;       // of what q^2 of the films' mean has of their own noise

    Sums& operator+=(const Sums& other) {
        if (products.empty()) products.resize(other.products.size());
        for (size_t i = 0; i < other.products.size(); ++i) products[i] += other.products[i];
        shared_terms += other.shared_terms;
        return *this;
    }
};

struct AllSums {
    Sums plain, relative;
    uint64_t count = 0;

    AllSums& operator+=(const AllSums& other) {
        plain += other.plain, relative += other.relative, count += other.count;
        return *this;
    }
};

/// Adds up runs of pixels: their values are laid out film after film, so that the compiler makes vectors of them.
class Sweep {
public:
    Sweep(const CrossMeter& references, std::span<const std::vector<float>> films)
        : references_(references), films_(films), errors_(films.size()) {
        for (Sums* sums : {&sums_.plain, &sums_.relative}) sums->products.resize(films.size() * (films.size() + 1) / 2);
    }

    /// Pixels [first, last).
    AllSums of(size_t first, size_t last) {
        for (size_t run = first; run < last; run += kRunPixels) {
            load(run, std::min(last, run + kRunPixels));
            add(sums_.plain, plain_weights_);
            add(sums_.relative, weights_);
        }
        return std::move(sums_);
    }

private:
    static constexpr size_t kWide = 8, kRunPixels = 64, kRun = 3 * kRunPixels;
    using Run = std::array<double, kRun>;

    /// What is not finite in any image, or beyond the last pixel, is 0 and weighs nothing.
    void load(size_t first, size_t last) {
        const size_t begin = 3 * first, count = 3 * (last - first);
        plain_weights_.fill(0), weights_.fill(0), half_differences_.fill(0);
        for (Run& errors : errors_) errors.fill(0);
        const double square = references_.unit() * references_.unit();
        for (size_t v = 0; v < count; ++v) {
            const double r = double{references_.mean_reference()[begin + v]};
            const double d = double{references_.half_difference()[begin + v]};
            double sum = r + d;
            for (size_t i = 0; i < films_.size(); ++i) {
                errors_[i][v] = double{films_[i][begin + v]} - r;
                sum += errors_[i][v];
            }
            if (std::isfinite(sum)) {
                half_differences_[v] = d, plain_weights_[v] = 1;
                weights_[v] = double{references_.weights()[begin + v]} / square;
                ++sums_.count;
            } else {
                for (Run& errors : errors_) errors[v] = 0;
            }
        }
    }

    static double weighted_product(const Run& a, const Run& b, const Run& weights) {
        std::array<double, kWide> lanes{};
        for (size_t v = 0; v < kRun; v += kWide)
            for (size_t lane = 0; lane < kWide; ++lane) lanes[lane] += a[v + lane] * b[v + lane] * weights[v + lane];
        double sum = 0;
        for (const double lane : lanes) sum += lane;
        return sum;
    }

    void add(Sums& sums, const Run& weights) {
        size_t pair = 0;
        for (size_t i = 0; i < errors_.size(); ++i)
            for (size_t j = 0; j <= i; ++j) sums.products[pair++] += weighted_product(errors_[i], errors_[j], weights);
        // q of each film's own e: their spread over k is what the films' noise adds to q^2 of their mean.
        const auto k = static_cast<double>(errors_.size());
        std::array<double, kRunPixels> of_mean{}, squares{};
        for (const Run& errors : errors_)
            for (size_t pixel = 0; pixel < kRunPixels; ++pixel) {
                double q = 0;
                for (size_t v = 3 * pixel; v < 3 * pixel + 3; ++v)
                    q += 2 * half_differences_[v] * errors[v] * weights[v];
                of_mean[pixel] += q / k, squares[pixel] += q * q;
            }
        for (size_t pixel = 0; pixel < kRunPixels; ++pixel)
            sums.shared_terms += std::max(0.0, squares[pixel] - k * of_mean[pixel] * of_mean[pixel]) / (k * (k - 1));
    }

    const CrossMeter& references_;
    const std::span<const std::vector<float>> films_;
    std::vector<Run> errors_;  // of each film over R
    Run half_differences_{}, plain_weights_{}, weights_{};
    AllSums sums_;
};

std::vector<float> mean_image(std::span<const std::vector<float>> films) {
    std::vector<float> mean(films.front().size());
    for_each_chunk(mean.size(), [&](size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) {
            double sum = 0;
            for (const std::vector<float>& film : films) sum += double{film[i]};
            mean[i] = static_cast<float>(sum / static_cast<double>(films.size()));
        }
    });
    return mean;
}

// --- From the sums to estimates

/// The value that a normal number stays below with `probability`.
double normal_quantile(double probability) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    return std::copysign(two_sided_student_t(std::fabs(2 * probability - 1), kInfinity), probability - 0.5);
}

/// The value that chi^2 stays below with `probability`; from three degrees on [Wilson and Hilferty 1931], good to a few
/// per cent. `normal`: the quantile of a normal number.
double chi_square_quantile(double probability, double normal, double degrees) {
    if (degrees == 1) return std::pow(normal_quantile((1 + probability) / 2), 2);
    if (degrees == 2) return -2 * std::log1p(-probability);
    const double width = 2 / (9 * degrees);
    return degrees * std::pow(1 - width + normal * std::sqrt(width), 3);
}

/// chi^2 over its degrees, at the middles of kCases equally likely ranges.
constexpr size_t kCases = 16;
using Cases = std::array<double, kCases>;
Cases chi_square_cases(double degrees) {
    const auto probability = [](size_t i) { return (static_cast<double>(i) + 0.5) / kCases; };
    static const Cases normals = [&] {
        Cases quantiles{};
        for (size_t i = 0; i < kCases; ++i) quantiles[i] = normal_quantile(probability(i));
        return quantiles;
    }();
    Cases cases{};
    for (size_t i = 0; i < kCases; ++i) cases[i] = chi_square_quantile(probability(i), normals[i], degrees) / degrees;
    return cases;
}

/// Pixels' own noise alone looks like a pattern of a tenth of V at the most.
constexpr double kSurePattern = 0.12;

/// What the sums of one kind of D say, over the number of values, and the error of the films' mean.
class Estimate {
public:
    Estimate(const Sums& sums, const CrossError& of_mean, size_t films, uint64_t count)
        : k_(static_cast<double>(films)), films_(films), gram_(films * films), with_mean_(films) {
        const auto n = static_cast<double>(count);
        size_t pair = 0;
        for (size_t i = 0; i < films; ++i)
            for (size_t j = 0; j <= i; ++j) gram_[i * films + j] = gram_[j * films + i] = sums.products[pair++] / n;
        // The films' own noise in q is in the spread of the g_i already.
        reference_variance_ =
            std::max(0.0, of_mean.standard_error * of_mean.standard_error - sums.shared_terms / (n * n));
        double trace = 0;
        for (size_t i = 0; i < films; ++i) {
            for (size_t j = 0; j < films; ++j) with_mean_[i] += gram_[i * films + j] / k_;
            trace += gram_[i * films + i], mean_square_ += with_mean_[i] / k_;
        }
        between_films_ = (k_ * k_ * mean_square_ - trace) / (k_ * (k_ - 1));
        centre();
        squared_bias_ = of_mean.value - centred_trace_ / (k_ - 1) / k_;
    }

    SeedError result() const {
        SeedError error;
        error.squared_bias = squared_bias_;
        error.squared_bias_interval = interval_of_bias();
        error.variance = centred_trace_ / (k_ - 1);
        if (films_ > 2) error.variance_interval = interval_of_variance();
        return error;
    }

private:
    /// M, and what follows from it.
    void centre() {
        centred_ = gram_;
        double squares = 0;
        for (size_t i = 0; i < films_; ++i)
            for (size_t j = 0; j < films_; ++j) {
                double& value = centred_[i * films_ + j];
                value += mean_square_ - with_mean_[i] - with_mean_[j];
                squares += value * value;
                if (i == j) centred_trace_ += value;
            }
        for (const double g : with_mean_) spread_ += (g - mean_square_) * (g - mean_square_) / (k_ - 1);
        if (films_ < 3 || !(centred_trace_ > 0)) return;
        const double traceless = squares - centred_trace_ * centred_trace_ / (k_ - 1);
        product_variance_ = std::max(0.0, traceless) / ((k_ - 2) * (k_ + 1));
        pattern_share_ = std::min(1.0, std::sqrt(product_variance_ * (k_ - 1) * (k_ + 1)) / centred_trace_);
    }

    Interval interval_of_bias() const {
        const double value = squared_bias_, h = half_width();
        const double w = std::pow(pattern_share_, 4);
        Interval interval{value - h, value + h};
        if (w == 0) return interval;
        const Interval of_pattern = interval_of_pattern();
        // Of the images' distance to R; the references' own noise joins by squares of the lengths.
        const double noise = kConfidenceZ * std::sqrt(reference_variance_);
        interval.least += w * (value - std::hypot(between_films_ - of_pattern.least, noise) - interval.least);
        interval.greatest += w * (value + std::hypot(of_pattern.greatest - between_films_, noise) - interval.greatest);
        return interval;
    }

    double half_width() const {
        const double excess = 4 / (k_ * k_) - 2 / (k_ * (k_ - 1)), m = (k_ - 2) * (k_ + 1) / 2;
        // Of the quadratic part at least so much is left, found by simulation: all of it makes intervals of three
        // images hold 98 of 100, nothing 86.
        const double least = std::min(1.0, 0.04 * (k_ - 2)) * 2 / (k_ * (k_ - 1));
        const Cases of_spread = chi_square_cases(k_ - 1), of_products = m > 0 ? chi_square_cases(m) : Cases{1};
        std::vector<double> deviations;
        for (const double s : of_spread)
            for (size_t i = 0; i < (m > 0 ? kCases : 1); ++i) {
                const double q = product_variance_ / of_products[i];
                const double variance = std::max(4 * spread_ / s / k_ - excess * q, least * q);
                deviations.push_back(std::sqrt(variance + reference_variance_));
            }
        double low = 0, high = 4 * *std::max_element(deviations.begin(), deviations.end());
        for (int i = 0; i < 18 && high > 0; ++i) {
            const double width = (low + high) / 2;
            double inside = 0;
            for (const double deviation : deviations)
                inside += deviation > 0 ? std::erf(width / deviation / std::numbers::sqrt2) : 1;
            (inside < kConfidence * static_cast<double>(deviations.size()) ? low : high) = width;
        }
        return high;
    }

    /// Of the squared distance to R, for noise of one pattern. A part of e along it, sure to be smaller than the noise,
    /// is no sign of bias: the least square is then below 0.
    Interval interval_of_pattern() const {
        double along = 0, squares = 0;  // g M g, and |g|^2, g less its mean: of one pattern p^2 is the square of the
        for (size_t i = 0; i < films_; ++i) {  // latter over the former
            const double g = with_mean_[i] - mean_square_;
            squares += g * g;
            for (size_t j = 0; j < films_; ++j) along += g * centred_[i * films_ + j] * (with_mean_[j] - mean_square_);
        }
        const double part = along > 0 ? std::sqrt(std::min(squares * squares / along, mean_square_)) : 0;
        const double rest = mean_square_ - part * part;
        const double h = two_sided_student_t(kConfidence, k_ - 1) * std::sqrt(centred_trace_ / (k_ - 1) / k_);
        return {rest + (part - h) * std::fabs(part - h), rest + (part + h) * (part + h)};
    }

    Interval interval_of_variance() const {
        const double variance = centred_trace_ / (k_ - 1);
        if (!(variance > 0)) return {};
        double spread = 0;  // of the M_ii
        for (size_t i = 0; i < films_; ++i)
            spread += std::pow(centred_[i * films_ + i] - centred_trace_ / k_, 2) / (k_ - 1);
        // The M_ii share the mean: of normal noise their spread is (k - 2) / k times 2 Q, the variance of V
        // 2 Q / (k - 1).
        const double deviation = std::sqrt(spread * k_ / ((k_ - 1) * (k_ - 2))) / variance;
        const double h = two_sided_student_t(kConfidence, k_ - 1) * deviation;
        // What one pattern makes of V, and what pixels' own noise does.
        const double of_pattern = pattern_share_ * variance, of_pixels = variance - of_pattern;
        const auto pattern_end = [&](double probability) {
            return of_pixels +
                   of_pattern * (k_ - 1) / chi_square_quantile(probability, normal_quantile(probability), k_ - 1);
        };
        const Interval narrow{variance * std::exp(-h), variance * std::exp(h)};
        const Interval of_both{pattern_end((1 + kConfidence) / 2), pattern_end((1 - kConfidence) / 2)};
        const Interval wide{std::min(narrow.least, of_both.least), std::max(narrow.greatest, of_both.greatest)};
        return mixed(mixed(wide, of_both, std::sqrt(pattern_share_)), narrow,
                     1 - std::min(1.0, std::pow(pattern_share_ / kSurePattern, 2)));
    }

    /// The share `of_second` of the second on a logarithmic scale; ends above 0.
    static Interval mixed(const Interval& first, const Interval& second, double of_second) {
        return {std::pow(first.least, 1 - of_second) * std::pow(second.least, of_second),
                std::pow(first.greatest, 1 - of_second) * std::pow(second.greatest, of_second)};
    }

    const double k_;
    const size_t films_;
    std::vector<double> gram_, centred_;  // G and M
    std::vector<double> with_mean_;       // g_i
    double mean_square_ = 0;              // <e, e>
    double between_films_ = 0;            // mean over i != j of G_ij
    double squared_bias_ = 0;             // that less what the references' noise adds
    double reference_variance_ = 0;       // that the references' noise adds to that of B
    double centred_trace_ = 0;
    double spread_ = 0;            // a
    double product_variance_ = 0;  // Q
    double pattern_share_ = 0;     // f
};

}  // namespace

const std::optional<SeedError>& SeedErrors::of(Metric mean_square) const {
    assert(is_quadratic(mean_square) && mean_square_of(mean_square) == mean_square);
    return mean_square == Metric::RelativeMse ? relative_mse : mse;
}

Metric mean_square_of(Metric metric) {
    assert(is_quadratic(metric));
    return metric == Metric::Rmse ? Metric::Mse : metric;
}

SeedErrors seed_errors(const CrossMeter& references, std::span<const std::vector<float>> films) {
    assert(films.size() >= 2);
    const Size2 size = references.size();
    for ([[maybe_unused]] const std::vector<float>& film : films) assert(film.size() == 3 * size.pixels());
    SeedErrors errors;
    errors.denominators = references.denominators();
    const AllSums sums = sum_of_chunks<AllSums>(
        size.pixels(), [&](size_t first, size_t last) { return Sweep(references, films).of(first, last); });
    errors.left_out = 3 * size.pixels() - sums.count;
    if (sums.count == 0) return errors;
    const CrossErrors of_mean = references.measure(mean_image(films));
    if (of_mean.mse) errors.mse = Estimate(sums.plain, *of_mean.mse, films.size(), sums.count).result();
    if (of_mean.relative_mse)
        errors.relative_mse = Estimate(sums.relative, *of_mean.relative_mse, films.size(), sums.count).result();
    return errors;
}

}  // namespace photond
