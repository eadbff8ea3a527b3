#pragma once
// What statistical tests decide with: chi-square, and intervals of means whose width follows from the samples.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace photond::test {

/// Upper tail of the standard normal distribution.
inline double normal_tail(double z) { return 0.5 * std::erfc(z / std::sqrt(2.0)); }

/// The z that a standard normal number passes, to either side, with this probability.
inline double two_sided_z(double probability) {
    double low = 0, high = 40;
    for (int i = 0; i < 200; ++i) {
        const double z = 0.5 * (low + high);
        (2 * normal_tail(z) > probability ? low : high) = z;
    }
    return low;
}

/// Chance of each of `checks` independent checks such that all together raise a false alarm with `false_alarm` (Sidak).
inline double share_of_false_alarm(double false_alarm, size_t checks) {
    return -std::expm1(std::log1p(-false_alarm) / static_cast<double>(checks));
}

/// Mean of independent samples and its standard error; sums of squares are taken about the running mean (Welford).
class RunningMean {
public:
    void add(double x) {
        ++count_;
        const double delta = x - mean_;
        mean_ += delta / static_cast<double>(count_);
        squares_ += delta * (x - mean_);
    }
    size_t count() const { return count_; }
    double mean() const { return mean_; }
    double variance() const { return count_ > 1 ? squares_ / static_cast<double>(count_ - 1) : 0; }
    double standard_error() const { return std::sqrt(variance() / static_cast<double>(count_)); }

private:
    size_t count_ = 0;
    double mean_ = 0, squares_ = 0;
};

/// Probability that a chi-square number with `degrees` of freedom exceeds x: the regularised upper incomplete gamma
/// function Q(degrees / 2, x / 2), by its series or continued fraction (Abramowitz and Stegun 6.5.29 and 6.5.31).
inline double chi_square_tail(double x, double degrees) {
    const double a = 0.5 * degrees, half = 0.5 * x;
    if (!(half > 0)) return 1;
    const double log_factor = a * std::log(half) - half - std::lgamma(a);
    if (half < a + 1) {
        double term = 1 / a, sum = term;
        for (double n = a + 1; term > sum * 1e-16; ++n) sum += term *= half / n;
        return 1 - sum * std::exp(log_factor);
    }
    constexpr double kTiny = 1e-300;
    double b = half + 1 - a, c = 1 / kTiny, d = 1 / b, h = d;
    for (int i = 1; i < 100000; ++i) {
        const double an = -i * (i - a);
        b += 2;
        d = an * d + b;
        d = 1 / (std::fabs(d) < kTiny ? kTiny : d);
        c = b + an / c;
        if (std::fabs(c) < kTiny) c = kTiny;
        h *= d * c;
        if (std::fabs(d * c - 1) < 1e-15) break;
    }
    return h * std::exp(log_factor);
}

/// Chi-square test of counts against expected counts. Cells with fewer than five expected are pooled, smallest first.
/// Returns the probability of a deviation at least this large by chance; 0 when something fell where nothing may.
inline double chi_square_probability(const std::vector<double>& observed, std::vector<double> expected) {
    double pooled_observed = 0, pooled_expected = 0, statistic = 0;
    size_t cells = 0;
    for (size_t i = 0; i < observed.size(); ++i) {
        if (expected[i] <= 0 && observed[i] > 0) return 0;
        if (expected[i] < 5) {
            pooled_observed += observed[i], pooled_expected += expected[i];
            continue;
        }
        statistic += (observed[i] - expected[i]) * (observed[i] - expected[i]) / expected[i];
        ++cells;
    }
    if (pooled_expected >= 5) {
        statistic += (pooled_observed - pooled_expected) * (pooled_observed - pooled_expected) / pooled_expected;
        ++cells;
    }
    return cells > 1 ? chi_square_tail(statistic, static_cast<double>(cells - 1))
                     : std::numeric_limits<double>::quiet_NaN();
}

/// Regularised incomplete beta function I_x(a, b), by its continued fraction (Abramowitz and Stegun 26.5.8).
inline double incomplete_beta(double a, double b, double x) {
    if (x > (a + 1) / (a + b + 2)) return 1 - incomplete_beta(b, a, 1 - x);
    if (x <= 0) return 0;
    constexpr double kTiny = 1e-300;
    double c = 1, d = 1 - (a + b) * x / (a + 1);
    d = 1 / (std::fabs(d) < kTiny ? kTiny : d);
    double h = d;
    for (int m = 1; m < 1000; ++m) {
        for (const double term : {m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
                                  -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1))}) {
            d = 1 + term * d;
            d = 1 / (std::fabs(d) < kTiny ? kTiny : d);
            c = 1 + term / c;
            if (std::fabs(c) < kTiny) c = kTiny;
            h *= c * d;
        }
        if (std::fabs(c * d - 1) < 1e-15) break;
    }
    return h * std::exp(a * std::log(x) + b * std::log1p(-x) + std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b)) /
           a;
}

/// The t that a Student-t number with `degrees` of freedom passes, to either side, with this probability.
inline double two_sided_t(double probability, double degrees) {
    double low = 0, high = 1e9;
    for (int i = 0; i < 200; ++i) {
        const double t = 0.5 * (low + high);
        (incomplete_beta(0.5 * degrees, 0.5, degrees / (degrees + t * t)) > probability ? low : high) = t;
    }
    return low;
}

/// Degrees of freedom of the difference of two means of independent samples [Welch 1947, Satterthwaite 1946]. Two
/// samples or more of each.
inline double degrees_of_difference(const RunningMean& a, const RunningMean& b) {
    const auto square = [](double x) { return x * x; };
    const double of_a = square(a.standard_error()), of_b = square(b.standard_error());
    return square(of_a + of_b) /
           (square(of_a) / static_cast<double>(a.count() - 1) + square(of_b) / static_cast<double>(b.count() - 1));
}

/// Mean of independent replicates and the half-width outside of which the true mean lies with the false-alarm rate.
struct Interval {
    double mean = 0;
    double half_width = 0;
};

/// Student's t over the replicates, shared among `checks` checks (Sidak).
inline Interval mean_interval(const std::vector<double>& replicates, double false_alarm, size_t checks) {
    RunningMean mean;
    for (const double x : replicates) mean.add(x);
    const double t = two_sided_t(share_of_false_alarm(false_alarm, checks), static_cast<double>(replicates.size()) - 1);
    return {mean.mean(), t * mean.standard_error()};
}

/// Least-squares slope of log values[i] over log 2^i: by what power of a number that doubles from value to value they
/// change. Two values or more, all above 0.
inline double slope_over_doublings(const std::vector<double>& values) {
    double products = 0, squares = 0;
    for (size_t i = 0; i < values.size(); ++i) {
        const double x = (static_cast<double>(i) - 0.5 * (static_cast<double>(values.size()) - 1)) * std::log(2.0);
        products += x * std::log(values[i]);
        squares += x * x;
    }
    return products / squares;
}

/// estimate(seed) for seeds 1 ... count.
template <class Estimate>
std::vector<double> replicates(size_t count, const Estimate& estimate) {
    std::vector<double> values;
    for (size_t seed = 1; seed <= count; ++seed) values.push_back(estimate(static_cast<uint64_t>(seed)));
    return values;
}

/// mean_interval() of estimate(1), estimate(2), ... that stops as soon as it is no wider than `half_width` to either
/// side: looked at after 4, 6, 9, 13 ... replicates, after `most` (4 or more) at the latest. Every look has an equal
/// part of the check's false-alarm rate (Bonferroni), so that choosing when to stop does not raise it.
template <class Estimate>
Interval interval_when_narrow(double half_width, size_t most, double false_alarm, size_t checks,
                              const Estimate& estimate) {
    std::vector<size_t> looks;
    for (size_t count = 4; count < most; count += count / 2) looks.push_back(count);
    looks.push_back(most);
    const double share = share_of_false_alarm(false_alarm, checks) / static_cast<double>(looks.size());
    std::vector<double> values;
    for (const size_t look : looks) {
        while (values.size() < look) values.push_back(estimate(static_cast<uint64_t>(values.size() + 1)));
        if (const Interval found = mean_interval(values, share, 1); found.half_width <= half_width) return found;
    }
    return mean_interval(values, share, 1);
}

}  // namespace photond::test
