#pragma once
// A request judged, and the job that follows from it written, told and queued.

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "protocol/job.h"
#include "server/service/estimates.h"
#include "server/service/job_intake.h"
#include "server/service/job_objects.h"
#include "server/service/prepared_job.h"
#include "server/service/references.h"
#include "server/service/request_checks.h"
#include "server/service/scenes.h"
#include "server/service/service_core.h"

namespace photond {

class Submissions {
public:
    Submissions(ServiceCore& core, Scenes& scenes, References& references, Estimates& estimates, JobIntake& intake,
                JobObjects& objects)
        : core_(core),
          scenes_(scenes),
          references_(references),
          estimates_(estimates),
          intake_(intake),
          objects_(objects),
          checks_(core, scenes, estimates) {}

    /// Takes the lock; may wait for the helper before. Durable when it returns. Throws what prepare_job() and
    /// JobIntake::check_room() throw, IdempotencyMismatch, and OutOfRange for what is no key.
    nlohmann::json submit_job(const JobRequest& request, const std::optional<std::string>& key,
                              const std::string& canonical_body);
    /// Takes the lock; may wait for the helper before. Throws what prepare_job() throws.
    nlohmann::json estimate_job(const JobRequest& request);

    /// Under the lock: judges a request and all it depends on. Throws UnknownName, Conflict, OutOfRange, Unsupported,
    /// DeviceUnavailable, OutOfMemory.
    PreparedJob prepare_job(const JobRequest& request);
    /// Without the lock: what will be written of a job, which judge_drafts() has still to judge; writing it takes the
    /// time where there are many. `scene`: its id. Throws DeviceUnavailable.
    PreparedJob draft_job(const JobRequest& request, const std::string& scene) const;
    /// Under the lock: judges jobs whose requests differ in time, seed and view alone, by which no job is refused: the
    /// first as prepare_job() does, and so all. `drafts`: one for each, or none, and then they are made. Throws
    /// likewise.
    std::vector<PreparedJob> judge_drafts(std::span<const JobRequest> requests, std::vector<PreparedJob> drafts);

private:
    /// Of jobs that are like this one but for time, seed and view.
    void complete_drafts(std::span<PreparedJob> drafts, const JobRequest& request, const SceneRef& scene);

    ServiceCore& core_;
    Scenes& scenes_;
    References& references_;
    Estimates& estimates_;
    JobIntake& intake_;
    JobObjects& objects_;
    RequestChecks checks_;
};

}  // namespace photond
