#include "clients/cli/compare_statistics.h"

#include <set>

#include "clients/cli/comparison_view.h"
#include "clients/cli/job_follower.h"
#include "clients/cli/units.h"

namespace photond::cli {

using nlohmann::json;

namespace {

/// Null for a job that has none, or has been removed since.
json statistics_of(DaemonClient& daemon, const std::string& job_id) {
    try {
        return daemon.get(resource_path("jobs", job_id)).value("statistics", json());
    } catch (const Failure& failure) {
        constexpr int kNotFound = 404;
        if (failure.problem.is_object() && failure.problem.value("status", 0) == kNotFound) return nullptr;
        throw;
    }
}

}  // namespace

std::vector<RowStatistics> statistics_of_rows(DaemonClient& daemon, const json& comparison) {
    std::vector<RowStatistics> rows;
    std::set<std::string> seen;
    for (const json& job : comparison.value("jobs", json::array())) {
        const std::string name = comparison_row_name(job);
        if (!is_over(job) || seen.contains(name)) continue;
        json statistics = statistics_of(daemon, job.at("id").get<std::string>());
        if (!statistics.is_object()) continue;
        seen.insert(name);
        rows.push_back({plain_text(job.value("label", json())), name, std::move(statistics)});
    }
    return rows;
}

}  // namespace photond::cli
