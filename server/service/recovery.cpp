#include "server/service/recovery.h"

#include <spdlog/spdlog.h>

#include <map>
#include <string>

#include "server/service/older_requests.h"

namespace photond {

void Recovery::begin() {
    {
        const std::lock_guard lock(core_.mutex);
        clear_away(find_stray_scratch(core_.files, core_.store), core_.files, quarantine_);  // may make room
        core_.open_events();
    }
    const bool finished = finish();
    const std::lock_guard lock(core_.mutex);
    // Not later, when an upload may be on its way in; else the next start does it.
    if (finished) clear_away_strays();
    fill_queue();
}

bool Recovery::finish() {
    const std::lock_guard lock(core_.mutex);
    try {
        recover_rows();
    } catch (const Error& error) {
        if (error.code != ErrorCode::NoSpace) throw;
        if (!told_)
            spdlog::error("no room to record what was running; until there is, jobs are served as they were: {}",
                          error.what());
        told_ = true;
        return false;
    }
    if (told_) spdlog::info("there is room again: what was running is recorded");
    return finished_ = true;
}

void Recovery::recover_rows() {
    complete_requests(core_.store, core_.vocabulary);
    const auto rendered = [this](int64_t seq) { return is_rendered(seq); };
    for (const LeftFilm& left : find_left_films(core_.files, core_.store, rendered)) {
        adopt(core_.store, left);
        purges_.remove_film(left.old_film);
    }
    for (const JobRow& row : core_.store.running_jobs())
        if (!is_rendered(row.seq)) attempts_.lost_with_daemon(row);
    for (const JobRow& row : core_.store.jobs_to_purge()) purges_.purge(row);
    purges_.finish_purges();
}

void Recovery::clear_away_strays() {
    if (!clear_away(find_stray_results(core_.files, core_.store), core_.files, quarantine_)) return;
    try {
        settle_files(core_.files, core_.store);
    } catch (const Error& error) {
        if (error.code != ErrorCode::NoSpace) throw;
        spdlog::warn("what was cleared away is noted at the next start: {}", error.what());
    }
}

void Recovery::fill_queue() {
    std::map<std::string, size_t> without_device;  // they are kept for a daemon that has it
    for (const QueuedJob& job : core_.store.queued_jobs()) {
        if (job.waits_for)
            core_.queue.hold(job.seq, job.priority, job.device, *job.waits_for);
        else
            core_.queue.push(job.seq, job.priority, job.device);
        if (!core_.has_device(job.device)) ++without_device[job.device];
    }
    for (const auto& [device, jobs] : without_device)
        spdlog::warn("{} jobs wait for device {}, which this daemon was not given (--devices)", jobs, device);
}

}  // namespace photond
