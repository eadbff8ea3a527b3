#pragma once
// The one sentence that a comparison comes to by a metric. Decided here for the API, the report and every client.

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/comparisons/verdict.h"

namespace photond {

/// Levels of error after each other of which the same is true.
struct Stretch {
    std::optional<size_t> row;  // the first to reach them; none: too close to call
    double easiest = 0;         // the largest of the levels
    double error = 0;           // the smallest
};

struct Headline {
    std::string metric;
    /// By falling error, from the table's largest level down to the smallest that any row reaches; never empty.
    std::vector<Stretch> stretches;
    /// The row whose look goes with the sentence: the only one that is first anywhere, else the one that is first at
    /// the smallest error; none where that is too close to call.
    std::optional<size_t> row;
    /// `row` is first at the smallest error, no other row is first anywhere, and none is clearly sooner at any level.
    bool best = false;
    /// Index of the verdict to show with the sentence: of those that bear `row` out, the one of the smallest error that
    /// two rows reach, for that says by how much; else the one of the smallest error.
    size_t verdict = 0;

    /// Rows that are first at some level, each once, in the order in which they take the lead.
    std::vector<size_t> leaders() const;
};

/// One for each metric that has a verdict, in their order. `verdicts`: verdicts(table). A row that reaches an error has
/// reached every larger one.
std::vector<Headline> headlines(const ComparisonTable& table, std::span<const Verdict> verdicts);

/// "It depends on the error you need: paths is first down to relative_mse 0.2, photons below that".
std::string headline_text(const ComparisonTable& table, const Headline& headline);

/// [{"metric", "text", "row", "best", "verdict", "stretches": [{"row", "easiest", "error"}]}]: rows are indices in the
/// table, `verdict` one in verdicts_json().
nlohmann::json headlines_json(const ComparisonTable& table, std::span<const Verdict> verdicts);

}  // namespace photond
