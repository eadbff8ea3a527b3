#pragma once
// What jobs are measured against: other jobs, uploaded images, and renderings made for it once and kept by content.

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "protocol/job.h"
#include "protocol/message_parts.h"
#include "server/service/prepared_job.h"
#include "server/service/scenes.h"
#include "server/service/service_core.h"

namespace photond {

/// All under the lock.
class References {
public:
    explicit References(ServiceCore& core) : core_(core) {}

    /// SHA-256 of what a reference shows and how it is made: two with the same are the same image.
    static std::string reference_content(const JobRequest& reference, const std::string& scene_id);
    /// What request.reference->rendering asks for, as a job of its own.
    static JobRequest reference_request(const JobRequest& request);

    /// Where the request's reference is to be rendered: fills in `reference_job` where a job of that content is there,
    /// else returns the job to insert. Nothing happens for references of other kinds. Throws DeviceUnavailable.
    std::optional<JobRow> missing_reference(const JobRequest& request, const SceneRef& scene,
                                            std::optional<int64_t>& reference_job);
    /// Inside a transaction: the job of that content that is there by now, else this one, inserted. Its seq.
    int64_t insert_reference(JobRow reference, Insertion& inserted);
    /// Inside a transaction: a reference that waits with a lower priority than a job that needs it gets that job's.
    void raise_reference(int64_t seq, int priority, Insertion& inserted);

    /// The job that is not over yet and that this one is measured against.
    std::optional<int64_t> waits_for(const JobRow& row);
    std::string waiting_text(const JobRow& row);  // for the log; empty when it does not wait
    /// What a job is measured against, once that is over; empty for a job without a reference. Throws WrongState, with
    /// the reason, where it is lost.
    std::optional<ImageSource> reference_source(const JobRow& row);
    /// Throws WrongState, naming one, while jobs that are not over are measured against this one; with `running` only
    /// those that run now count.
    void check_unused(const JobRow& row, bool running);

private:
    /// One that is finished, or will be.
    std::optional<JobRow> usable_reference(const std::string& content);

    ServiceCore& core_;
};

}  // namespace photond
