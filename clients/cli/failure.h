#pragma once
// How photonctl ends: its exit codes (a promise to scripts) and the one exception that carries one.

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

namespace photond::cli {

enum class ExitCode : int {
    Ok = 0,
    JobFailed = 1,
    Usage = 2,
    Unreachable = 3,
    Refused = 4,
    Cancelled = 5,
    TimedOut = 6,
    LocalFile = 7,
    Interrupted = 130,
};

struct ExitCodeRow {
    ExitCode code;
    const char* name;  // `code` of a failure in JSON where the daemon gave none
    const char* meaning;
};

// Printed below `photonctl --help`.
inline constexpr ExitCodeRow kExitCodes[] = {
    {ExitCode::Ok, "ok", "done"},
    {ExitCode::JobFailed, "job_failed", "the job failed, or a check of `doctor` or `hard-cases` did"},
    {ExitCode::Usage, "usage", "the command line or a file given on it cannot be used; nothing was sent"},
    {ExitCode::Unreachable, "unreachable", "the daemon cannot be reached, or was lost for longer than is retried"},
    {ExitCode::Refused, "refused", "the daemon refused; every fault is printed with its place"},
    {ExitCode::Cancelled, "cancelled", "the job was cancelled"},
    {ExitCode::TimedOut, "timed_out", "--timeout passed; the job goes on"},
    {ExitCode::LocalFile, "local_file", "a result could not be written here"},
    {ExitCode::Interrupted, "interrupted",
     "interrupted (Ctrl-C); the job goes on unless --cancel-on-interrupt was given"},
};

/// Ends the command: what happened, what to do about it, and with which exit code.
class Failure : public std::runtime_error {
public:
    Failure(ExitCode exit_code, const std::string& message, std::string what_to_do = {})
        : std::runtime_error(message), code(exit_code), hint(std::move(what_to_do)) {}
    /// The daemon's own words: `document` is its problem+json.
    Failure(const std::string& message, nlohmann::json document)
        : std::runtime_error(message), code(ExitCode::Refused), problem(std::move(document)) {}

    const ExitCode code;
    const std::string hint;                  // a line, or a list below one; may be empty
    const nlohmann::json problem = nullptr;  // application/problem+json, null where there is none
};

}  // namespace photond::cli
