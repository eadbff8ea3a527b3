#pragma once
// What a job's statistics say of its error (protocol.md, "Shapes"; conventions.md, "Error").

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/message_parts.h"
#include "server/worker/error_follower.h"

namespace photond {

struct ErrorStatistics {
    nlohmann::json error = nullptr;            // {metric: value}, of several numbers where the metric has them
    nlohmann::json error_interval = nullptr;   // {metric: [least, greatest]}: of what was measured against two films
    nlohmann::json reference_error = nullptr;  // {metric: value}: what the reference's own noise explains
    /// {"source", "form", "confidence", "denominators", "passes", "flip_version", "warnings", "notes"}
    nlohmann::json reference = nullptr;
    nlohmann::json estimate = nullptr;  // what the passes alone tell
    std::vector<std::string> warnings;  // for the log
};

/// Of a film after its last pass; `last`: the curve's last point. `asked`: the job's reference as the request names it,
/// and what that was.
ErrorStatistics error_statistics(ResolvedFilm& film, FilmErrors& errors, const MeasuringPlan& plan,
                                 const CurvePoint& last, const nlohmann::json& asked,
                                 const std::optional<ReferenceSource>& source);

/// The one noise that every reference is tried with (with_own_noise()): figures can be repeated.
inline constexpr uint64_t kReferenceNoiseSeed = 1;

/// Three numbers, R, G and B; null for a channel that has no value.
nlohmann::json channels_json(const std::array<std::optional<double>, 3>& values);

/// A sentence for each metric that says little of the image: its value is less than three times the reference's own.
/// One with an interval says in that what is known of it.
std::vector<std::string> noise_warnings(const nlohmann::json& error, const nlohmann::json& error_interval,
                                        const nlohmann::json& reference_error);

/// What notes say of quadratic metrics against two films.
inline constexpr std::string_view kRootBelowZero =
    "the mean square, whose root it is, is estimated below 0: the references' noise hides it";
inline constexpr std::string_view kDividedByNeighbours =
    "divided by what the references have around each pixel, whose own values are too noisy for it";

}  // namespace photond
