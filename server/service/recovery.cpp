#include "server/service/recovery.h"

#include <spdlog/spdlog.h>

#include <map>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>

#include "protocol/worker_messages.h"

namespace photond {

using nlohmann::json;

void recover(ServiceCore& core, Attempts& attempts, Purges& purges) {
    const std::lock_guard lock(core.mutex);
    core.open_events();
    for (const JobRow& row : core.store.running_jobs()) attempts.lost_with_daemon(row);
    for (const JobRow& row : core.store.jobs_to_purge()) purges.purge(row);
    purges.finish_purges();
    std::map<std::string, size_t> without_device;  // they are kept for a daemon that has it
    for (const QueuedJob& job : core.store.queued_jobs()) {
        if (job.waits_for)
            core.queue.hold(job.seq, job.priority, job.device, *job.waits_for);
        else
            core.queue.push(job.seq, job.priority, job.device);
        if (!core.has_device(job.device)) ++without_device[job.device];
    }
    for (const auto& [device, jobs] : without_device)
        spdlog::warn("{} jobs wait for device {}, which this daemon was not given (--devices)", jobs, device);
}

void sweep_orphans(ServiceCore& core) {
    const std::lock_guard lock(core.mutex);
    const auto as_set = [](std::vector<std::string> names) {
        return std::unordered_set<std::string>(names.begin(), names.end());
    };
    std::vector<std::string> named = core.store.films();
    for (const auto& [film, names] : core.store.artefacts())
        for (const json& name : json::parse(names))
            named.push_back(artefact_path(film, name.get<std::string>()).string());
    const size_t swept_films = DataFiles::sweep(core.files.films, as_set(std::move(named)));
    const size_t swept_scenes = DataFiles::sweep(core.files.scenes, as_set(core.store.scene_ids()));
    const size_t swept_images = DataFiles::sweep(core.files.images, as_set(core.store.image_files()));
    if (swept_films + swept_scenes + swept_images > 0)
        spdlog::info("removed what no row names: {} films, {} scenes, {} images", swept_films, swept_scenes,
                     swept_images);
}

}  // namespace photond
