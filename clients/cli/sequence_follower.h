#pragma once
// Follows a sequence to its end, its progress shown.

#include <nlohmann/json.hpp>
#include <string>

#include "clients/cli/job_view.h"
#include "clients/cli/session.h"

namespace photond::cli {

/// "12 of 120 frames, 3 min left".
std::string sequence_figures(const nlohmann::json& sequence);

/// With its frames. Throws Failure as wait_for() does.
nlohmann::json wait_for_sequence(Session& session, const std::string& id, const WaitOptions& options);

}  // namespace photond::cli
