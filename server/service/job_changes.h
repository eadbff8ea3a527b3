#pragma once
// Jobs that are there already, changed: another priority, another try, more passes.

#include <nlohmann/json.hpp>
#include <string>

#include "server/service/attempts.h"
#include "server/service/estimates.h"
#include "server/service/job_intake.h"
#include "server/service/job_objects.h"
#include "server/service/references.h"
#include "server/service/repeats.h"
#include "server/service/scenes.h"
#include "server/service/service_core.h"
#include "server/service/submissions.h"

namespace photond {

/// All take the lock, are durable when they return, and throw NotFound, and WrongState in states that do not permit it.
class JobChanges {
public:
    JobChanges(ServiceCore& core, Scenes& scenes, References& references, Attempts& attempts, Estimates& estimates,
               JobIntake& intake, Submissions& submissions, JobObjects& objects)
        : core_(core),
          scenes_(scenes),
          references_(references),
          attempts_(attempts),
          estimates_(estimates),
          intake_(intake),
          submissions_(submissions),
          repeats_(core),
          objects_(objects) {}

    /// `body`: {"priority": ...}.
    nlohmann::json change_job(const std::string& id, const nlohmann::json& body);
    nlohmann::json retry_job(const std::string& id);
    /// The same request as a new job, which is returned; one of a comparison in its place. May wait for the helper
    /// before. Throws WrongState where the job, or a repeat of it, is not over, and as Submissions::submit_job() does.
    nlohmann::json repeat_job(const std::string& id);
    /// `body`: {"stop": ...}; the conditions count from the film's first pass. Throws Conflict where the film meets
    /// them already.
    nlohmann::json extend_job(const std::string& id, const nlohmann::json& body);

private:
    /// Under the lock: back to the queue, its film kept; `log_line` says why. Makes its reference anew where that is
    /// gone.
    nlohmann::json queue_again(JobRow row, const std::string& log_line);

    ServiceCore& core_;
    Scenes& scenes_;
    References& references_;
    Attempts& attempts_;
    Estimates& estimates_;
    JobIntake& intake_;
    Submissions& submissions_;
    Repeats repeats_;
    JobObjects& objects_;
};

}  // namespace photond
