#pragma once
// Following and showing jobs, as `render` and `jobs` both do.

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "clients/cli/session.h"
#include "clients/cli/transfer.h"

namespace photond::cli {

struct WaitOptions {
    double timeout_seconds = 0;  // 0: none
    bool cancel_on_interrupt = false;
};

/// --timeout and --cancel-on-interrupt.
void add_wait_options(CLI::App& command, WaitOptions& options);
/// Where the image, its previews, its photons and its errors are saved.
void add_output_options(CLI::App& command, JobOutputs& outputs);

/// Runs `follow`, which returns what it followed when that is over. Throws Failure: Interrupted, TimedOut and
/// Unreachable say how to go on. With cancel_on_interrupt an interrupt cancels it and nothing is returned: it then only
/// has to come to its end. `kind`: job or comparison.
std::optional<nlohmann::json> wait_for(Session& session, const std::string& kind, const std::string& id,
                                       const WaitOptions& options, const std::function<nlohmann::json()>& follow);

/// DELETE of each, with everything it has where `remove`, and what became of it. `kind`: jobs, comparisons or
/// sequences; `what_stays`: of one that is ended.
ExitCode cancel_all(Session& session, const std::string& kind, const std::vector<std::string>& ids, bool remove,
                    const std::string& what_stays);

/// Follows a job with its progress shown; with `print_changes` every change is also printed as JSON. Throws Failure:
/// Interrupted and TimedOut say how to go on; with cancel_on_interrupt an interrupt cancels the job, which is returned.
nlohmann::json wait_for_job(Session& session, const std::string& id, const WaitOptions& options, bool print_changes);

/// 0 succeeded, 1 failed, 5 cancelled.
ExitCode exit_code_of(const nlohmann::json& job);

/// State, request, failure and statistics.
void print_job(const Session& session, const nlohmann::json& job);
/// Why a job failed, every fault with its place; nothing for other jobs.
/// Where it was disturbed: so, and the command that runs it again.
void remark_disturbance(const Session& session, const nlohmann::json& job);
void remark_failure(const Session& session, const nlohmann::json& job);

}  // namespace photond::cli
