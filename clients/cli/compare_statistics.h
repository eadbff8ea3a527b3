#pragma once
// What the jobs of a comparison say of themselves, row by row.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "clients/cli/session.h"

namespace photond::cli {

struct RowStatistics {
    std::string label, name;    // of the entry; of the row, with what its sweep gave
    nlohmann::json statistics;  // an object
};

/// Of the first job of each row that is over and has statistics. Throws Failure.
std::vector<RowStatistics> statistics_of_rows(DaemonClient& daemon, const nlohmann::json& comparison);

}  // namespace photond::cli
