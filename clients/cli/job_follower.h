#pragma once
// Follows one job to its end: by its event stream, by asking again and again where there is none.

#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "clients/cli/daemon_client.h"

namespace photond::cli {

/// succeeded, failed or cancelled.
bool is_over(const nlohmann::json& job);

/// Called with the whole job object whenever something in it has changed; `event`: progress, curve or state.
using JobListener = std::function<void(const nlohmann::json& job, const std::string& event)>;

/// Returns the job when it is over. A lost stream is taken up where it broke off (Last-Event-ID). Throws Failure:
/// Interrupted and TimedOut leave the job running, Unreachable when the daemon stays away longer than is retried.
nlohmann::json follow_job(DaemonClient& daemon, const std::string& id, const JobListener& listener);

}  // namespace photond::cli
