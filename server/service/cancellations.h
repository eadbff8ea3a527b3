#pragma once
// Jobs cancelled: those that wait at once, those that run when their workers let go of them.

#include <functional>
#include <string>
#include <vector>

#include "server/service/attempts.h"
#include "server/service/job_objects.h"
#include "server/service/purges.h"
#include "server/service/references.h"
#include "server/service/service_core.h"
#include "server/service/service_types.h"
#include "server/service/waiting_jobs.h"

namespace photond {

class Cancellations {
public:
    Cancellations(ServiceCore& core, References& references, WaitingJobs& waiting, Purges& purges, Attempts& attempts,
                  JobObjects& objects)
        : core_(core),
          references_(references),
          waiting_(waiting),
          purges_(purges),
          attempts_(attempts),
          objects_(objects) {}

    /// Takes the lock. With `remove` the job and its files go too, once it is over. Throws NotFound; with `remove`
    /// WrongState for a job of a comparison and for one that others are measured against.
    Cancelled cancel_job(const std::string& id, bool remove);
    /// Under the lock: cancels what waits and asks for what runs to be cancelled, in one transaction with `more`.
    /// Whoever calls has other jobs begin (Attempts::dispatch).
    void cancel_jobs(std::vector<JobRow> rows, const std::function<void()>& more, bool remove);

private:
    ServiceCore& core_;
    References& references_;
    WaitingJobs& waiting_;
    Purges& purges_;
    Attempts& attempts_;
    JobObjects& objects_;
};

}  // namespace photond
