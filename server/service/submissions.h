#pragma once
// A request judged, and the job that follows from it written, told and queued.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

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

private:
    ServiceCore& core_;
    Scenes& scenes_;
    References& references_;
    Estimates& estimates_;
    JobIntake& intake_;
    JobObjects& objects_;
    RequestChecks checks_;
};

}  // namespace photond
