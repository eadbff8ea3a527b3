#include "server/service/job_intake.h"

#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>

namespace photond {

void JobIntake::check_room(size_t jobs, uint64_t disk_bytes) const {
    if (core_.stopping) throw Error(ErrorCode::Unavailable, "the daemon is stopping and takes no new jobs");
    if (core_.queue.size() + jobs > core_.options.limits.max_queue)
        throw Error(ErrorCode::QueueFull, std::to_string(core_.queue.size()) + " jobs are waiting, the limit is " +
                                              std::to_string(core_.options.limits.max_queue));
    core_.check_disk(disk_bytes);
}

void JobIntake::check_room(std::span<const PreparedJob> jobs) const {
    uint64_t disk_bytes = 0;
    size_t number = jobs.size();
    std::unordered_set<std::string_view> contents;  // each film is made once
    for (const PreparedJob& job : jobs) {
        disk_bytes += job.disk_bytes;
        for (size_t film = 0; film < job.references.size(); ++film) {
            if (!contents.insert(job.references[film].content).second) continue;
            disk_bytes += job.reference_disk_bytes[film];
            ++number;
        }
    }
    check_room(number, disk_bytes);
}

void JobIntake::insert_job(PreparedJob& job, Insertion& inserted) {
    if (!job.references.empty()) job.row.reference_jobs = references_.insert_references(job.references, inserted);
    references_.raise_references(job.row, inserted);
    core_.store.insert_job(job.row);
    core_.store.append_log(job.row.seq, job.row.created_ms,
                           "queued for " + job.row.device + references_.waiting_text(job.row));
    core_.put_event(inserted.outbox, "state", job.row.seq, ServiceCore::state_data(job.row));
    inserted.rows.push_back(job.row);
}

void JobIntake::accept(Insertion inserted) {
    core_.tell(std::move(inserted.outbox));
    for (const JobRow& row : inserted.rows) {
        core_.queue.remove(row.seq);  // one whose priority rose
        waiting_.enqueue(row);
    }
    attempts_.dispatch();
}

}  // namespace photond
