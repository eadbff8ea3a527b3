#pragma once
// Jobs as clients see them: one, or a list of them.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "server/service/attempts.h"
#include "server/service/scenes.h"
#include "server/service/service_core.h"
#include "server/service/service_types.h"

namespace photond {

class JobObjects {
public:
    JobObjects(ServiceCore& core, Scenes& scenes, Attempts& attempts)
        : core_(core), scenes_(scenes), attempts_(attempts) {}

    /// Takes the lock. Throws NotFound.
    nlohmann::json get_job(const std::string& id);
    /// Takes the lock for a few jobs at a time. Throws OutOfRange for what the filter says wrongly, before it writes.
    void list_jobs(const JobFilter& filter, const TextSink& write);

    /// Under the lock. Throws NotFound.
    JobRow require_job(const std::string& id);
    /// Under the lock: the job an idempotency key was used for. Throws IdempotencyMismatch when that was with another
    /// body.
    std::optional<JobRow> job_of_key(const std::string& key, const std::string& body_sha256);
    /// Under the lock: a running job is further than its row says.
    std::string job_text(const JobRow& row) const;
    nlohmann::json job_object(const JobRow& row) const { return nlohmann::json::parse(job_text(row)); }

private:
    // Under the lock; nothing where the job has been removed.
    std::optional<std::string> listed_job(int64_t seq);
    std::optional<std::string> listed_summary(int64_t seq);
    nlohmann::json job_summary(const JobSummary& row);

    ServiceCore& core_;
    Scenes& scenes_;
    Attempts& attempts_;
};

}  // namespace photond
