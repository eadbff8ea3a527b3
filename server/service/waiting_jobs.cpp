#include "server/service/waiting_jobs.h"

#include <spdlog/spdlog.h>

#include "protocol/problem.h"
#include "server/clock_text.h"
#include "server/row_text.h"

namespace photond {

using nlohmann::json;

std::optional<int64_t> WaitingJobs::waits_for(const JobRow& row) {
    if (const auto reference = references_.waits_for(row)) return reference;
    return frames_.waits_for(row);
}

void WaitingJobs::enqueue(const JobRow& row) {
    if (row.state != JobState::Queued) return;
    if (const auto until = waits_for(row))
        core_.queue.hold(row.seq, row.priority, row.device, *until);
    else
        core_.queue.push(row.seq, row.priority, row.device);
}

void WaitingJobs::ended(const JobRow& row) {
    ++core_.totals.jobs[std::string(job_state_name(row.state))];
    core_.metrics.job_ended(std::string(job_state_name(row.state)), row.method, row.device, row.seconds,
                            parsed_or_null(row.statistics));
    if (row.comparison && row.role != JobRole::Frame) core_.comparisons_to_look_at.insert(*row.comparison);
    core_.attempt_changed.notify_all();
    release_waiting(row);
}

void WaitingJobs::cancel(JobRow& row, const std::string& line) {
    row.state = JobState::Cancelled;
    row.finished_ms = now_ms();
    core_.commit_state(row, line);
    core_.queue.remove(row.seq);
    ended(row);
    cancel_unneeded_references(row);
}

void WaitingJobs::cancel_unneeded_references(const JobRow& of) {
    for (const int64_t seq : of.reference_jobs)
        if (auto film = core_.store.job(seq); film && film->role == JobRole::Reference &&
                                              film->state == JobState::Queued &&
                                              core_.store.unfinished_jobs_measured_against(seq).empty())
            cancel(*film, "cancelled: nothing is to be measured against it any more");
}

void WaitingJobs::fail_for_reference(JobRow row, const std::string& reason) {
    row.state = JobState::Failed;
    row.finished_ms = now_ms();
    row.failure = problem_json(ErrorCode::WrongState, reason, {}, "/v1/jobs/" + job_id(row.seq))
                      .dump(-1, ' ', false, json::error_handler_t::replace);
    core_.commit_state(row, "failed: " + reason);
    core_.queue.remove(row.seq);
    ended(row);
    spdlog::warn("job {} failed: {}", job_id(row.seq), reason);
    cancel_unneeded_references(row);
}

void WaitingJobs::release_waiting(const JobRow& over) {
    for (const int64_t seq : core_.queue.release(over.seq)) {
        // Where this does not come through, the job is in the queue, and judged again when its turn comes.
        try {
            auto row = core_.store.job(seq);
            if (!row || row->state != JobState::Queued) continue;
            try {
                references_.check_not_lost(*row);
            } catch (const Error& error) {
                fail_for_reference(*std::move(row), error.what());
                continue;
            }
            if (!waits_for(*row)) continue;
            core_.queue.remove(seq);
            enqueue(*row);  // until what else it waits for is there
        } catch (const std::exception& error) {
            spdlog::error("job {}: that what it waited for is over cannot be recorded yet: {}", job_id(seq),
                          error.what());
        }
    }
}

}  // namespace photond
