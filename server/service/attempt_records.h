#pragma once
// How attempts went, written into their jobs' rows. An attempt's number is its fencing token: what comes with another
// one than its job's row has is ignored.

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "protocol/worker_messages.h"
#include "server/service/purges.h"
#include "server/service/repeats.h"
#include "server/service/running_attempt.h"
#include "server/service/saved_film.h"
#include "server/service/service_core.h"
#include "server/service/waiting_jobs.h"
#include "server/workers/worker_process.h"

namespace photond {

/// All under the lock. They throw where the store cannot be written, and may be called again then.
class AttemptRecords {
public:
    AttemptRecords(ServiceCore& core, WaitingJobs& waiting, Purges& purges)
        : core_(core), waiting_(waiting), purges_(purges) {}

    /// The worker has said how it ended.
    void record_result(const RunningAttempt& attempt, const FinishedMessage& message, const std::string& device);
    /// The worker has ended before it did. `left`: what saved_film() found of the attempt, which the worker may have
    /// saved and not told.
    void record_loss(const RunningAttempt& attempt, const ProcessExit& exit, bool daemon_stopping,
                     const std::optional<FilmFacts>& left);
    /// The attempt has saved its film: from here on the job goes on from there, whatever becomes of the attempt.
    void keep_film(const RunningAttempt& attempt, int64_t passes_done);

private:
    /// Of the artefacts a worker names, those that the method declares and that are there.
    nlohmann::json kept_artefacts(const JobRow& row, const std::vector<std::string>& names) const;
    /// An attempt that found nothing left to render has no artefacts of its own: gives it those beside the film that it
    /// went on from, and returns their names.
    std::vector<std::string> inherit_artefacts(const JobRow& before, const RunningAttempt& attempt) const;

    ServiceCore& core_;
    WaitingJobs& waiting_;
    Purges& purges_;
    Repeats repeats_{core_};
};

}  // namespace photond
