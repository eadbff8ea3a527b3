#pragma once
// The faults of a problem+json as lines for people: each of them once.

#include <nlohmann/json.hpp>
#include <string>

#include "clients/cli/session.h"

namespace photond::cli {

/// `headline` after `before`, then the faults with their places; a single one stands in the headline instead.
void remark_problem(const Session& session, const std::string& before, const std::string& headline,
                    const nlohmann::json& problem);

}  // namespace photond::cli
