#pragma once
// Comparisons: a request, the jobs it means, and what follows from those. A comparison is written with all its jobs in
// one transaction, and from there on everything is read off them.

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "protocol/comparison.h"
#include "server/service/job_groups.h"
#include "server/service/scenes.h"
#include "server/service/service_core.h"
#include "server/service/service_types.h"

namespace photond {

class Comparisons {
public:
    Comparisons(ServiceCore& core, Scenes& scenes, References& references, Purges& purges, Attempts& attempts,
                Jobs& jobs)
        : core_(core),
          scenes_(scenes),
          attempts_(attempts),
          jobs_(jobs),
          groups_(core, references, purges, attempts, jobs, GroupKind::Comparison) {}

    // --- these take the lock
    /// May wait for the helper before. Durable, with all its jobs, when it returns; all of them are accepted or none.
    /// Throws as Submissions::submit_job() does, faults at their places in the comparison's body.
    nlohmann::json submit_comparison(const ComparisonRequest& request, const std::optional<std::string>& key);
    /// What submit_comparison() would queue, after all its checks, and what that will take. May wait for the helper
    /// before.
    nlohmann::json estimate_comparison(const ComparisonRequest& request);
    /// Throws NotFound, as all do that are given an id.
    nlohmann::json get_comparison(const std::string& id);
    /// Throws the faults of the body.
    void change_comparison(const std::string& id, const nlohmann::json& body);
    /// Throws OutOfRange.
    Page list_comparisons(uint32_t limit, const std::string& cursor);
    /// With `remove` its jobs and their files go too. Throws WrongState then, where jobs of others are measured against
    /// one of them.
    Cancelled cancel_comparison(const std::string& id, bool remove);
    Compared read_comparison(const std::string& id);

private:
    // --- under the lock
    /// Its jobs, judged; faults are at their places in the comparison's body.
    std::vector<PreparedJob> prepare_jobs(const ComparisonRequest& request);
    Compared read_comparison(const ComparisonRow& row);

    ServiceCore& core_;
    Scenes& scenes_;
    Attempts& attempts_;
    Jobs& jobs_;
    JobGroups groups_;
};

}  // namespace photond
