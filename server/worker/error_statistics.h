#pragma once
// What a job's statistics say of its error (protocol.md, "Shapes"; conventions.md, "Error").

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "server/worker/error_follower.h"

namespace photond {

struct ErrorStatistics {
    nlohmann::json error = nullptr;            // {metric: value}, of several numbers where the metric has them
    nlohmann::json reference_error = nullptr;  // {metric: value}: what the reference's own noise explains
    nlohmann::json reference = nullptr;        // {"source", "passes", "flip_version", "warnings", "notes"}
    nlohmann::json estimate = nullptr;         // what the passes alone tell
    std::vector<std::string> warnings;         // for the log
};

/// Of a film after its last pass; `last`: the values of the curve's last point. `source`: the job's reference as the
/// request names it.
ErrorStatistics error_statistics(ResolvedFilm& film, FilmErrors& errors, const MeasuringPlan& plan,
                                 const MetricValues& last, const nlohmann::json& source);

/// The one noise that every reference is tried with (with_own_noise()): figures can be repeated.
inline constexpr uint64_t kReferenceNoiseSeed = 1;

/// Three numbers, R, G and B; null for a channel that has no value.
nlohmann::json channels_json(const std::array<std::optional<double>, 3>& values);

/// A sentence for each metric that says little of the image: its value is less than three times the reference's own.
std::vector<std::string> noise_warnings(const nlohmann::json& error, const nlohmann::json& reference_error);

}  // namespace photond
