#pragma once
// Jobs whose films are parts of one image, joined into one: exact, for sums of passes know no order.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "server/service/job_films.h"
#include "server/service/job_objects.h"
#include "server/service/purges.h"
#include "server/service/service_core.h"

namespace photond {

class JobMerges {
public:
    JobMerges(ServiceCore& core, Purges& purges, JobObjects& objects, JobFilms& films)
        : core_(core), purges_(purges), objects_(objects), films_(films) {}

    /// `body`: {"jobs": [ids]}. Takes the lock, and waits for the helper without it. Throws faults at /jobs/i,
    /// IdempotencyMismatch, Unavailable when stopping, NoSpace.
    nlohmann::json merge_jobs(const nlohmann::json& body, const std::optional<std::string>& key);

private:
    std::vector<JobRow> jobs_to_merge(const std::vector<std::string>& ids);  // under the lock; faults at /jobs/i
    nlohmann::json add_merged(JobRow row, const std::filesystem::path& film, const std::vector<std::string>& ids,
                              const std::optional<std::string>& key, const std::string& body_sha256);

    ServiceCore& core_;
    Purges& purges_;
    JobObjects& objects_;
    JobFilms& films_;
};

}  // namespace photond
