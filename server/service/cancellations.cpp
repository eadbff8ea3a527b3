#include "server/service/cancellations.h"

#include "server/clock_text.h"

namespace photond {

using nlohmann::json;

Cancelled Cancellations::cancel_job(const std::string& id, bool remove) {
    const std::lock_guard lock(core_.mutex);
    JobRow row = objects_.require_job(id);
    if (remove) purges_.check_not_compared(row);
    if (remove) references_.check_unused(row, false);
    if (is_over(row.state)) {
        json object = objects_.job_object(row);
        if (remove) purges_.purge(row);
        return {std::move(object), true};
    }
    if (row.state == JobState::Queued) {
        waiting_.cancel(row, "cancelled while queued");
        attempts_.dispatch();
        json object = objects_.job_object(row);
        if (remove) purges_.purge(row);
        return {std::move(object), false};
    }
    if (!row.cancel_requested || (remove && !row.purge_requested)) {
        row.cancel_requested = true;
        row.purge_requested = row.purge_requested || remove;
        auto transaction = core_.store.transaction();
        core_.store.update_job(row);
        core_.store.append_log(row.seq, now_ms(), "to be cancelled");
        transaction.commit();
    }
    attempts_.cancel_running(row.seq);
    return {objects_.job_object(row), false};
}

void Cancellations::cancel_jobs(std::vector<JobRow> rows, const std::function<void()>& more, bool remove) {
    Outbox outbox;
    {
        auto transaction = core_.store.transaction();
        for (JobRow& row : rows) {
            if (is_over(row.state)) continue;
            const bool waiting = row.state == JobState::Queued;
            if (waiting) {
                row.state = JobState::Cancelled;
                row.finished_ms = now_ms();
            } else {
                row.cancel_requested = true;
                row.purge_requested = row.purge_requested || remove;
            }
            core_.store.update_job(row);
            core_.store.append_log(row.seq, now_ms(), waiting ? "cancelled while queued" : "to be cancelled");
            if (waiting) core_.put_event(outbox, "state", row.seq, ServiceCore::state_data(row));
        }
        more();
        transaction.commit();
    }
    core_.tell(std::move(outbox));
    for (const JobRow& row : rows)
        if (row.state == JobState::Cancelled && core_.queue.remove(row.seq)) waiting_.ended(row);
    for (const JobRow& row : rows)
        if (!is_over(row.state)) attempts_.cancel_running(row.seq);
}

}  // namespace photond
