#pragma once
// The table of hard cases: what each cell has to be rendered for, and what is found in it.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clients/cli/hard_cases_entries.h"
#include "clients/cli/hard_cases_renders.h"
#include "clients/cli/hard_cases_scenes.h"

namespace photond::cli {

struct TableOptions {
    double effort = 1;  // factor on the suggested passes
    bool small_images = false;
    RenderLimits limits;
};

enum class Verdict : uint8_t { Holds, Breaks, NotApplicable };
const char* wire_name(Verdict verdict);

/// What was found of one check of a case.
struct CheckFound {
    HardCheck check;
    bool holds = false;
    std::string text;                    // "holds", "holds (to +-7.1 %)", "breaks: ...": the verdict with its figure
    std::optional<Judgement> judgement;  // of relations with an interval, once two seeds have given pixels
    Radiance measured{}, answer{};       // means over the seeds; the answer 0 where there is none
    WorstPixel worst;                    // relative as the judgement; of `zero`, radiance
};

/// One case by one entry.
struct Cell {
    Verdict verdict = Verdict::NotApplicable;
    std::string text;                  // the verdict in words: why not applicable, how wide it holds, what breaks
    std::string reason;                // what is known of why it breaks; may be empty
    std::vector<std::string> defects;  // what must never happen, and did
    std::vector<std::string> notes;
    std::vector<CheckFound> checks;
    std::optional<size_t> shown;  // of `checks`: the one a table shows
    uint64_t nan = 0, infinite = 0, negative = 0;
    double seconds = 0;  // of its jobs, references left out
    std::vector<std::string> jobs;
};

struct HardCasesTable {
    std::vector<HardCase> cases;
    std::vector<TableEntry> entries;
    std::vector<std::vector<Cell>> cells;  // [case][entry]; none of a case that a test covers
    TableOptions options;
    size_t comparisons = 0;  // that share kTableFalseAlarm: of cells, checks and channels
    size_t jobs = 0;

    struct Summary {
        size_t holds = 0, breaks = 0, not_applicable = 0, defects = 0;  // cells; defects: those that have any
    };
    Summary summary() const;
};

/// Renders what the cells need and judges them. Throws Failure where the daemon is lost or the command interrupted. The
/// jobs of cells that break are left to be looked at, the others are removed; all are left with `keep_jobs`.
HardCasesTable measure_table(Session& session, std::vector<HardCase> cases, std::vector<TableEntry> entries,
                             const TableOptions& options, bool keep_jobs);

}  // namespace photond::cli
