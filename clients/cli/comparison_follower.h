#pragma once
// Comparisons from submission to tables, as `compare` and `comparisons` both show them.

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "clients/cli/job_view.h"
#include "clients/cli/session.h"

namespace photond::cli {

/// Where the reports of a comparison are saved.
struct ReportOutputs {
    std::vector<std::string> html;  // self-contained pages
    std::string csv, json;

    /// Throws Failure(Usage) for a page that is not named .html, before anything is rendered.
    void check() const;
    bool any() const { return !html.empty() || !csv.empty() || !json.empty(); }
};

/// -o, --csv and --json-report.
void add_report_options(CLI::App& command, ReportOutputs& outputs);
void save_reports(Session& session, const std::string& id, const ReportOutputs& outputs);

/// Follows a comparison with its progress shown; with `print_changes` every change is also printed as JSON. Throws
/// Failure as wait_for_job() does.
nlohmann::json wait_for_comparison(Session& session, const std::string& id, const WaitOptions& options,
                                   bool print_changes);

/// Follows it to its end, saves its reports and prints its tables and verdicts (with --json the object instead).
ExitCode finish_comparison(Session& session, const std::string& id, const WaitOptions& wait,
                           const ReportOutputs& outputs, bool print_changes);

/// State, entries, tables, verdicts and each entry's memory.
void print_comparison(Session& session, const nlohmann::json& comparison);

}  // namespace photond::cli
