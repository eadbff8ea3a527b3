#pragma once
// What is kept with a saved film (film_file.h, `history`) so that its statistics, its clock and its curve are of the
// whole film, whatever attempts rendered it.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "protocol/worker_messages.h"
#include "renderer/core/stats.h"
#include "renderer/error/curve.h"

namespace photond {

struct FilmHistory {
    double seconds = 0;  // on the job's clock: begin, passes and resolve
    Counts counts;
    std::vector<Stage> stages;
    std::vector<Skipped> skipped;
    std::vector<CurvePoint> curve;
    std::optional<double> standard_error_scale;  // of the beauty, as ErrorEstimate's
    CoreUse cores;                               // without what derive() fills in; unknown of older films

    /// The text that is saved.
    std::string text() const;
    /// Reads it. Empty text is a film without a history. Throws ErrorCode::Internal when it is not one of these.
    static FilmHistory parse(const std::string& text);

    /// Adds what another part of the same image took: seconds, counts, stages and cores add up, what was skipped is
    /// named once. Curve and scale are of a film as it was and are dropped.
    FilmHistory& operator+=(const FilmHistory& other);
};

/// Adds those stages to these, by name; new names at the end.
void add_stages(std::vector<Stage>& stages, const std::vector<Stage>& others);
/// Adds those that are not there yet.
void add_skipped(std::vector<Skipped>& skipped, const std::vector<Skipped>& others);

/// {"seconds", "passes", "photons", "metrics"} (protocol.md, "Shapes"); what is empty is null.
nlohmann::json to_json(const CurvePoint& point);
nlohmann::json to_json(const std::vector<CurvePoint>& curve);

}  // namespace photond
