#pragma once
// Jobs taken in: room for them, their rows with log and event, their places in the queue.
//
//     std::vector<PreparedJob> jobs;  // of Submissions::prepare_job(); set row.comparison
//     intake.check_room(jobs);
//     Insertion inserted;
//     auto transaction = store.transaction();
//     for (PreparedJob& job : jobs) intake.insert_job(job, inserted);  // fills in job.row.seq
//     transaction.commit();
//     intake.accept(std::move(inserted));

#include <cstdint>
#include <span>

#include "server/service/attempts.h"
#include "server/service/prepared_job.h"
#include "server/service/references.h"
#include "server/service/service_core.h"
#include "server/service/waiting_jobs.h"

namespace photond {

/// All under the lock, which is not let go of from check_room() to accept().
class JobIntake {
public:
    JobIntake(ServiceCore& core, References& references, WaitingJobs& waiting, Attempts& attempts)
        : core_(core), references_(references), waiting_(waiting), attempts_(attempts) {}

    /// Throws Unavailable when stopping, QueueFull, NoSpace.
    void check_room(std::span<const PreparedJob> jobs) const;
    void check_room(size_t jobs, uint64_t disk_bytes) const;
    /// Inside the caller's transaction: writes the job with its log and event, and before it its reference unless one
    /// of that content is there by now.
    void insert_job(PreparedJob& job, Insertion& inserted);
    /// After the commit: tells the events, queues the jobs and has them begin.
    void accept(Insertion inserted);

private:
    ServiceCore& core_;
    References& references_;
    WaitingJobs& waiting_;
    Attempts& attempts_;
};

}  // namespace photond
