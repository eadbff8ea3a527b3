#pragma once
// From a job's request to its result, as `render` and `repeat` both go: submit, watch, save.

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "clients/cli/job_view.h"

namespace photond::cli {

struct JobRun {
    std::string idempotency_key;
    bool no_wait = false;
    bool dry_run = false;
    WaitOptions wait;
    JobOutputs outputs;

    /// Before anything is sent. Throws Failure for options that exclude each other and for places where nothing can be
    /// written.
    void check(const Session& session) const;
    /// Throws Failure(Usage) for results that a job with these `layers` will not have, or without a reference.
    void check_results(Session& session, const nlohmann::json& layers, bool has_reference) const;
};

/// --dry-run, --no-wait, what is saved and how long is waited.
void add_run_options(CLI::App& command, JobRun& run);

/// To be called after both checks.
ExitCode run_job(Session& session, const nlohmann::json& request, const JobRun& run);

}  // namespace photond::cli
