#include "clients/cli/hard_cases_verdict.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "clients/cli/units.h"

namespace photond::cli {

namespace {

struct RelationName {
    Relation relation;
    const char* name;
};
constexpr std::array<RelationName, 6> kRelations = {{{Relation::Equals, "equals"},
                                                     {Relation::AtMost, "at_most"},
                                                     {Relation::SameAs, "same_as"},
                                                     {Relation::Reference, "reference"},
                                                     {Relation::Zero, "zero"},
                                                     {Relation::Finite, "finite"}}};

// Renderers compute in 32-bit floats, and pixels come as such: some ten roundings of 6e-8. Without it a method whose
// seeds agree to the bit would break by its last digit.
constexpr double kPixelRounding = 1e-6;
// A holding cell whose interval is wider says how wide.
constexpr double kNarrow = 0.05;

/// P(|T| < sqrt(degrees) tan(theta)) for a whole number of degrees of freedom [Abramowitz and Stegun 1964, 26.7.3 and
/// 26.7.4]. (renderer/error/student_t.h has the service's; clients see the protocol alone.)
double student_t_inside(double theta, size_t degrees) {
    const double cosine = std::cos(theta), sine = std::sin(theta);
    const bool odd = degrees % 2 == 1;
    double sum = 0, term = odd ? cosine : 1;
    for (size_t k = odd ? 1 : 0; k + 2 <= degrees; k += 2) {
        sum += term;
        term *= cosine * cosine * static_cast<double>(k + 1) / static_cast<double>(k + 2);
    }
    return odd ? 2 / std::numbers::pi * (theta + sine * sum) : sine * sum;
}

/// Mean and standard error of one channel's differences.
struct MeanOfDifferences {
    double mean = 0, standard_error = 0;
};
MeanOfDifferences mean_of_differences(const RegionSamples& samples, size_t channel) {
    const auto count = static_cast<double>(samples.means.size());
    const auto difference = [&](size_t i) { return samples.means[i][channel] - samples.answers[i][channel]; };
    MeanOfDifferences found;
    for (size_t i = 0; i < samples.means.size(); ++i) found.mean += difference(i) / count;
    double squares = 0;
    for (size_t i = 0; i < samples.means.size(); ++i) squares += std::pow(difference(i) - found.mean, 2);
    found.standard_error = std::sqrt(squares / (count - 1) / count);
    return found;
}

}  // namespace

Radiance mean_of(const std::vector<Radiance>& values) {
    Radiance mean{};
    for (const Radiance& value : values)
        for (size_t c = 0; c < kChannels; ++c) mean[c] += value[c] / static_cast<double>(values.size());
    return mean;
}

std::optional<Relation> relation_from(std::string_view wire_name) {
    for (const RelationName& row : kRelations)
        if (row.name == wire_name) return row.relation;
    return std::nullopt;
}

const char* wire_name(Relation relation) {
    const auto row =
        std::find_if(kRelations.begin(), kRelations.end(), [&](const auto& r) { return r.relation == relation; });
    assert(row != kRelations.end());
    return row->name;
}

bool has_interval(Relation relation) { return relation != Relation::Zero && relation != Relation::Finite; }

double shared_false_alarm(double false_alarm, size_t comparisons) {
    return -std::expm1(std::log1p(-false_alarm) / static_cast<double>(std::max<size_t>(comparisons, 1)));
}

double two_sided_t(double probability, size_t degrees) {
    assert(degrees >= 1 && probability >= 1e-13 && probability < 1);
    double low = 0, high = std::numbers::pi / 2;
    for (int i = 0; i < 100; ++i) {
        const double theta = 0.5 * (low + high);
        (1 - student_t_inside(theta, degrees) > probability ? low : high) = theta;
    }
    return std::sqrt(static_cast<double>(degrees)) * std::tan(low);
}

Judgement judge(Relation relation, const RegionSamples& samples, double false_alarm) {
    assert(has_interval(relation));
    assert(samples.means.size() >= 2 && samples.means.size() == samples.answers.size());
    // One side alone raises an alarm where the answer is a bound: all of the chance is that side's.
    const double t =
        two_sided_t(relation == Relation::AtMost ? 2 * false_alarm : false_alarm, samples.means.size() - 1);
    const Radiance answer = mean_of(samples.answers);
    const double brightest = std::max({std::abs(answer[0]), std::abs(answer[1]), std::abs(answer[2])});
    Judgement worst;
    double worst_excess = 0;
    for (size_t c = 0; c < kChannels; ++c) {
        const MeanOfDifferences found = mean_of_differences(samples, c);
        const double scale = answer[c] != 0 ? std::abs(answer[c]) : brightest > 0 ? brightest : 1;
        Judgement judgement{false, brightest > 0, c, found.mean / scale, found.standard_error / scale, 0};
        const double rounding = brightest > 0 ? kPixelRounding : 0;
        judgement.half_width = t * judgement.standard_error + samples.tolerance + rounding;
        const double deviation = relation == Relation::AtMost ? judgement.bias : std::abs(judgement.bias);
        judgement.holds = deviation <= judgement.half_width;  // written so that NaN breaks
        const double excess = std::isfinite(deviation) ? deviation - judgement.half_width : HUGE_VAL;
        if (c == 0 || excess > worst_excess) worst = judgement, worst_excess = excess;
    }
    return worst;
}

std::string verdict_text(const Judgement& judgement) {
    if (!judgement.holds) return "breaks";
    if (judgement.half_width <= kNarrow) return "holds";
    return judgement.relative ? "holds (to +-" + three_digit_number(100 * judgement.half_width) + " %)"
                              : "holds (to +-" + three_digit_number(judgement.half_width) + ")";
}

}  // namespace photond::cli
