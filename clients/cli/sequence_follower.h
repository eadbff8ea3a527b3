#pragma once
// Follows a sequence to its end, its progress shown.

#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "clients/cli/job_view.h"
#include "clients/cli/session.h"

namespace photond::cli {

/// Frames that are over, and all.
std::pair<size_t, size_t> frames_over(const nlohmann::json& sequence);
/// "12 of 120 frames, 3 min left".
std::string sequence_figures(const nlohmann::json& sequence);

/// With its frames. `told` of each look at it, without its frames. Throws Failure as wait_for() does.
nlohmann::json wait_for_sequence(
    Session& session, const std::string& id, const WaitOptions& options,
    const std::function<void(const nlohmann::json& summary)>& told = [](const nlohmann::json&) {});

}  // namespace photond::cli
