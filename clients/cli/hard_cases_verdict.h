#pragma once
// Whether what was measured of a hard case keeps to its known answer. Statistics alone: no daemon, no JSON.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace photond::cli {

/// Radiance [W m^-2 sr^-1], per channel.
using Radiance = std::array<double, 3>;

/// What a known answer says of a region of a layer.
enum class Relation : uint8_t {
    Equals,     // its mean is this radiance
    AtMost,     // its mean is no more than this radiance
    SameAs,     // its mean is that of another scene, rendered alike, times a factor
    Reference,  // its mean is that of a path-traced reference
    Zero,       // every pixel of it is exactly black
    Finite,     // no figure: only what must never happen is looked for
};
std::optional<Relation> relation_from(std::string_view wire_name);
const char* wire_name(Relation relation);
/// Relations that are decided by an interval, and share the table's false alarms.
bool has_interval(Relation relation);

/// Chance that a whole table without a defect has a single wrong `breaks`.
inline constexpr double kTableFalseAlarm = 1e-6;
constexpr size_t kChannels = 3;

/// Of each channel; not a number without values.
Radiance mean_of(const std::vector<Radiance>& values);

/// Chance of each of `comparisons` independent ones such that all together raise a false alarm with `false_alarm`
/// [Sidak 1967, Rectangular confidence regions for the means of multivariate normal distributions].
double shared_false_alarm(double false_alarm, size_t comparisons);

/// The t that |T| exceeds with this probability, T Student's with `degrees` >= 1 of freedom. `probability` in
/// [1e-13, 1): below that the distribution function is too near 1 for double precision.
double two_sided_t(double probability, size_t degrees);

/// One region of one layer, seed by seed.
struct RegionSamples {
    std::vector<Radiance> means;    // of the region
    std::vector<Radiance> answers;  // what each should have been: of the same length; a fixed answer is repeated
    double tolerance = 0;           // of the answer itself, relative
};

/// How far off the channel is that exceeds its tolerance by most. Figures are relative to the answer's channel, to its
/// brightest channel where that one is black, and radiance where all of the answer is black.
struct Judgement {
    bool holds = false;
    bool relative = true;
    size_t channel = 0;
    double bias = 0;
    double standard_error = 0;  // of the bias, between seeds
    double half_width = 0;      // the bias it may have: t standard errors, the tolerance, the rounding of the pixels
};

/// Student's t over the seeds' differences from their answers: where both are random and rendered by the same seed,
/// or by seeds of their own, they are taken in pairs, so that nothing need be known of how they depend on each other.
/// `relation`: one with an interval. At least two seeds. A defect of ours otherwise (assert).
Judgement judge(Relation relation, const RegionSamples& samples, double false_alarm);

/// "holds", "holds (to +-7.1 %)" where the interval is wider than 5 %, "breaks".
std::string verdict_text(const Judgement& judgement);

}  // namespace photond::cli
