#pragma once
// Jobs that wait for their turn: in the queue, or beside it until what they are measured against, or follow from, is
// over.

#include <string>

#include "server/service/frame_order.h"
#include "server/service/references.h"
#include "server/service/service_core.h"

namespace photond {

/// All under the lock.
class WaitingJobs {
public:
    WaitingJobs(ServiceCore& core, References& references) : core_(core), references_(references), frames_(core) {}

    /// A job that is not over yet and that this one is measured against, or else follows as a frame.
    std::optional<int64_t> waits_for(const JobRow& row);
    /// Puts a queued job where it belongs: into the queue, or beside it.
    void enqueue(const JobRow& row);
    /// A job is over and its row says so: it is counted, and those that were waiting for it are queued, or fail where
    /// it left nothing to measure against.
    void ended(const JobRow& row);
    /// Cancels a job that is queued, and what waits to be rendered for it alone; `line` is for its log.
    void cancel(JobRow& row, const std::string& line);
    /// Fails a job that has lost what it is measured against; `reason` says how.
    void fail_for_reference(JobRow row, const std::string& reason);

private:
    /// Films of its reference that wait to be rendered, now for nobody; one that is being rendered is finished and
    /// kept.
    void cancel_unneeded_references(const JobRow& of);
    void release_waiting(const JobRow& over);

    ServiceCore& core_;
    References& references_;
    FrameOrder frames_;
};

}  // namespace photond
