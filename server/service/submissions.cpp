#include "server/service/submissions.h"

#include "renderer/core/sha256.h"
#include "server/clock_text.h"
#include "server/left_out_json.h"
#include "server/service/idempotency_key.h"

namespace photond {

using nlohmann::json;

PreparedJob Submissions::draft_job(const JobRequest& request, const std::string& scene) const {
    PreparedJob job;
    job.row.priority = request.priority;
    job.row.device = core_.device_of(request.method);
    job.row.method = request.method.name;
    job.row.scene = scene;
    job.row.request = to_json(request).dump();
    if (request.reference && !request.reference->job.empty())
        job.row.reference_jobs = {job_seq(request.reference->job)};
    job.references = references_.reference_films(request, scene);
    return job;
}

void Submissions::complete_drafts(std::span<PreparedJob> drafts, const JobRequest& request, const SceneRef& scene) {
    const uint64_t disk_bytes = estimates_.estimate_disk_bytes(request, scene);
    std::vector<uint64_t> film_bytes;
    for (uint32_t film = 0; film < drafts.front().references.size(); ++film)
        film_bytes.push_back(estimates_.estimate_disk_bytes(References::reference_request(request, film), scene));
    const int64_t now = now_ms();
    for (PreparedJob& job : drafts) {
        job.row.created_ms = now;
        job.disk_bytes = disk_bytes;
        references_.leave_missing(job.references, job.row.reference_jobs);
        for (JobRow& film : job.references) film.created_ms = now;
        if (!job.references.empty()) job.reference_disk_bytes = film_bytes;
    }
}

PreparedJob Submissions::prepare_job(const JobRequest& request) {
    const SceneRef scene = checks_.check_request(request);
    PreparedJob job = draft_job(request, scene.id);
    complete_drafts({&job, 1}, request, scene);
    return job;
}

std::vector<PreparedJob> Submissions::judge_drafts(std::span<const JobRequest> requests,
                                                   std::vector<PreparedJob> drafts) {
    const SceneRef scene = checks_.check_request(requests.front());
    if (drafts.empty() || drafts.front().row.scene != scene.id) {  // its name is another scene's since
        drafts.clear();
        for (const JobRequest& request : requests) drafts.push_back(draft_job(request, scene.id));
    }
    complete_drafts(drafts, requests.front(), scene);
    return drafts;
}

json Submissions::submit_job(const JobRequest& request, const std::optional<std::string>& key,
                             const std::string& canonical_body) {
    const std::string body_sha256 = key ? sha256_hex(canonical_body.data(), canonical_body.size()) : "";
    if (key) check_idempotency_key(*key);
    scenes_.know_scene(request.scene);
    const std::lock_guard lock(core_.mutex);
    if (key)
        if (const auto known = objects_.job_of_key(*key, body_sha256)) return objects_.job_object(*known);
    if (core_.stopping) throw Error(ErrorCode::Unavailable, "the daemon is stopping and takes no new jobs");
    PreparedJob job = prepare_job(request);
    intake_.check_room({&job, 1});
    Insertion inserted;
    {
        auto transaction = core_.store.transaction();
        intake_.insert_job(job, inserted);
        if (key) core_.store.insert_key(*key, body_sha256, job.row.seq, job.row.created_ms);
        transaction.commit();
    }
    json object = objects_.job_object(job.row);  // as accepted, whatever happens next
    intake_.accept(std::move(inserted));
    return object;
}

json Submissions::estimate_job(const JobRequest& request) {
    scenes_.know_scene(request.scene);
    const std::lock_guard lock(core_.mutex);
    const SceneRef scene = checks_.check_request(request);
    EarlierJobs earlier;
    const TimeEstimate time = estimates_.estimate_time(request, scene, earlier);
    const auto on_device = estimates_.estimate_device_bytes(request, scene);
    return {{"memory_bytes", estimates_.estimate_memory_bytes(request, scene)},
            {"device_memory_bytes", on_device ? json(*on_device) : json()},
            {"seconds", time.seconds ? json(*time.seconds) : json()},
            {"pass_seconds", time.pass_seconds ? json(*time.pass_seconds) : json()},
            {"left_out", to_json(estimates_.paths_left_out(request, scene))},
            {"warnings", time.warning.empty() ? json::array() : json::array({time.warning})}};
}

}  // namespace photond
