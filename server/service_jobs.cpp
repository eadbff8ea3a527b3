// Jobs as clients see them: submitted, looked at, listed, cancelled, retried, purged.

#include <spdlog/spdlog.h>

#include <algorithm>

#include "protocol/nearest_name.h"
#include "protocol/openapi.h"
#include "protocol/worker_messages.h"
#include "renderer/core/sha256.h"
#include "renderer/methods/registry.h"
#include "renderer/scene/builtin_scenes.h"
#include "server/clock_text.h"
#include "server/service_impl.h"

namespace photond {

using nlohmann::json;

namespace {

constexpr size_t kMaxKeyBytes = 255;

json parsed_or_null(const std::string& text) { return text.empty() ? json() : json::parse(text); }
json time_or_null(const std::optional<int64_t>& ms) { return ms ? json(rfc3339(*ms)) : json(); }

void check_key(const std::string& key) {
    const bool printable = std::all_of(key.begin(), key.end(), [](char c) { return c > 31 && c < 127; });
    if (key.empty() || key.size() > kMaxKeyBytes || !printable)
        throw Error(ErrorCode::OutOfRange,
                    "an Idempotency-Key has 1 to " + std::to_string(kMaxKeyBytes) + " printable ASCII characters");
}

std::string nearest_hint(const std::string& wrong, const std::vector<std::string>& known) {
    const std::string near = nearest_name(wrong, known);
    return near.empty() ? "" : "; did you mean '" + near + "'?";
}

}  // namespace

JobRow Service::Impl::require_job(const std::string& id) {
    if (const int64_t seq = job_seq(id); seq != 0)
        if (auto row = store.job(seq)) return *std::move(row);
    throw Error(ErrorCode::NotFound, "there is no job '" + id + "'");
}

json Service::Impl::job_object(const JobRow& row) const {
    int64_t passes_done = row.passes_done;
    double progress = row.progress, seconds = row.seconds;
    for (const auto& slot : slots)
        if (slot->running && slot->running->seq == row.seq && row.state == JobState::Running) {
            passes_done = slot->running->passes_done;
            progress = slot->running->progress;
            seconds = slot->running->seconds;
        }
    const std::string self = "/v1/jobs/" + job_id(row.seq);
    json links = {{"self", self},
                  {"image", self + "/image.exr"},
                  {"preview", self + "/preview.png"},
                  {"statistics", self + "/statistics.json"},
                  {"curve", nullptr},
                  {"log", self + "/log.txt"},
                  {"events", self + "/events"}};
    for (const ArtefactInfo& artefact : all_artefacts()) links[artefact_link(std::string(artefact.name))] = nullptr;
    for (const json& name : json::parse(row.artefacts))
        links[artefact_link(name.get<std::string>())] = self + "/" + name.get<std::string>();
    return {{"id", job_id(row.seq)},
            {"state", job_state_name(row.state)},
            {"progress", progress},
            {"passes_done", passes_done},
            {"seconds", seconds},
            {"error_now", nullptr},
            {"created", rfc3339(row.created_ms)},
            {"started", time_or_null(row.started_ms)},
            {"finished", time_or_null(row.finished_ms)},
            {"attempts", json::parse(row.attempts)},
            {"request", json::parse(row.request)},
            {"links", links},
            {"statistics", parsed_or_null(row.statistics)},
            {"failure", parsed_or_null(row.failure)},
            {"curve", nullptr}};
}

std::string Service::Impl::device_of(const JobRequest& request) const {
    std::string known;
    for (const std::string& device : options.devices) {
        if (device == request.method.device || (request.method.device == "gpu" && device.starts_with("gpu:"))) return device;
        known += (known.empty() ? "" : ", ") + device;
    }
    throw Error(ErrorCode::DeviceUnavailable, "/method/device",
                "this daemon has no device '" + request.method.device + "'; it has: " + known);
}

Service::Impl::SceneRef Service::Impl::check_request(const JobRequest& request) {
    const std::string device = device_of(request);
    auto scene = find_scene(request.scene);
    if (!scene) {
        std::vector<std::string> known;
        for (const std::string_view name : builtin_scene_names()) known.emplace_back(name);
        for (const SceneRow& row : store.scenes(INT64_MAX, 1000)) known.push_back(row.name);
        throw Error(ErrorCode::UnknownName, "/scene",
                    "there is no scene '" + request.scene + "'" + nearest_hint(request.scene, known));
    }
    if (!request.camera.name.empty()) {
        std::vector<std::string> cameras;
        if (scene->builtin) {
            cameras.emplace_back("camera");
        } else {
            const json summary = json::parse(scene->row->summary);
            for (const json& camera : summary.value("cameras", json::array()))
                cameras.push_back(camera.value("name", ""));
        }
        if (std::find(cameras.begin(), cameras.end(), request.camera.name) == cameras.end())
            throw Error(
                ErrorCode::UnknownName, "/camera/name",
                "the scene has no camera '" + request.camera.name + "'" + nearest_hint(request.camera.name, cameras));
    }
    if (request.environment) {
        const std::string& image = request.environment->image;
        if (!image.starts_with("image:") || !store.image(image.substr(6)))
            throw Error(ErrorCode::UnknownName, "/environment/image", "there is no image '" + image + "'");
    }
    const uint64_t bytes = estimate_memory_bytes(request, *scene);
    const std::string needs = "; the job needs about " + std::to_string(bytes) + " bytes";
    const uint64_t pixels = uint64_t{request.width} * request.height;
    if (pixels > options.limits.max_pixels)
        throw Error(ErrorCode::OutOfRange, "/image",
                    std::to_string(request.width) + " x " + std::to_string(request.height) + " = " +
                        std::to_string(pixels) + " pixels, the limit is " + std::to_string(options.limits.max_pixels) +
                        needs);
    if (bytes > options.memory_limit_bytes)
        throw Error(ErrorCode::OutOfMemory, "/image",
                    "the limit of a worker is " + std::to_string(options.memory_limit_bytes) + " bytes" + needs);
    return *std::move(scene);
}

json Service::Impl::submit_job(const JobRequest& request, const std::optional<std::string>& key,
                               const std::string& canonical_body) {
    const std::string body_sha256 = key ? sha256_hex(canonical_body.data(), canonical_body.size()) : "";
    if (key) check_key(*key);
    const std::lock_guard lock(mutex);
    if (key)
        if (const auto known = store.key(*key)) {
            if (known->body_sha256 != body_sha256)
                throw Error(ErrorCode::IdempotencyMismatch,
                            "the Idempotency-Key was used with another body, for job " + job_id(known->job));
            return job_object(require_job(job_id(known->job)));
        }
    if (stopping) throw Error(ErrorCode::Unavailable, "the daemon is stopping and takes no new jobs");
    const SceneRef scene = check_request(request);
    if (queue.size() >= options.limits.max_queue)
        throw Error(ErrorCode::QueueFull, std::to_string(queue.size()) + " jobs are waiting, the limit is " +
                                              std::to_string(options.limits.max_queue));
    check_disk(estimate_disk_bytes(request, scene));

    JobRow row;
    row.priority = request.priority;
    row.device = device_of(request);
    row.method = request.method.name;
    row.scene = scene.id;
    row.request = to_json(request).dump();
    row.created_ms = now_ms();
    const std::vector<std::pair<std::string, std::string>> labels(request.labels.begin(), request.labels.end());
    {
        auto transaction = store.transaction();
        store.insert_job(row, labels);
        if (key) store.insert_key(*key, body_sha256, row.seq, row.created_ms);
        store.append_log(row.seq, row.created_ms, "queued for " + row.device);
        Event event = state_event(row);
        const uint64_t reserved = reserve_event_ids(1);
        store.insert_event(event, row.seq);
        transaction.commit();
        event_ids_until = reserved;
        events.publish(std::move(event));
    }
    json object = job_object(row);  // as accepted, whatever happens next
    queue.push(row.seq, row.priority, row.device);
    dispatch();
    return object;
}

json Service::Impl::get_job(const std::string& id) {
    const std::lock_guard lock(mutex);
    return job_object(require_job(id));
}

Page Service::Impl::list_jobs(const JobFilter& filter) {
    check_limit(filter.limit);
    JobQuery query;
    query.limit = filter.limit;
    query.before = read_cursor(filter.cursor, INT64_MAX);
    if (!filter.state.empty()) {
        query.state = job_state_named(filter.state);
        if (!query.state)
            throw Error(ErrorCode::OutOfRange, "/state",
                        "'" + filter.state + "' is none of queued, running, succeeded, failed, cancelled");
    }
    if (!filter.label.empty()) {
        const size_t equals = filter.label.find('=');
        query.label_key = filter.label.substr(0, equals);
        if (equals != std::string::npos) query.label_value = filter.label.substr(equals + 1);
        if (query.label_key.empty()) throw Error(ErrorCode::OutOfRange, "/label", "a label is KEY or KEY=VALUE");
    }
    query.method = filter.method;
    json items = json::array();
    json next;
    const std::lock_guard lock(mutex);
    if (!filter.scene.empty()) {
        // A scene that has been deleted is still found by its id.
        const auto scene = find_scene(filter.scene);
        query.scene = scene ? scene->id : filter.scene;
    }
    const std::vector<JobRow> rows = store.jobs(query);
    for (const JobRow& row : rows) items.push_back(job_object(row));
    if (rows.size() == filter.limit) next = std::to_string(rows.back().seq);
    return {{"items", std::move(items)}, {"next_cursor", std::move(next)}};
}

Service::Cancelled Service::Impl::cancel_job(const std::string& id, bool remove) {
    const std::lock_guard lock(mutex);
    JobRow row = require_job(id);
    if (is_over(row.state)) {
        json object = job_object(row);
        if (remove) purge(row);
        return {std::move(object), true};
    }
    if (row.state == JobState::Queued) {
        row.state = JobState::Cancelled;
        row.finished_ms = now_ms();
        commit_state(row, "cancelled while queued");
        queue.remove(row.seq);
        ended(row);
        json object = job_object(row);
        if (remove) purge(row);
        return {std::move(object), false};
    }
    if (!row.cancel_requested || (remove && !row.purge_requested)) {
        row.cancel_requested = true;
        row.purge_requested = row.purge_requested || remove;
        auto transaction = store.transaction();
        store.update_job(row);
        store.append_log(row.seq, now_ms(), "to be cancelled");
        transaction.commit();
    }
    if (Slot* slot = slot_of(row.seq)) cancel_running(*slot);
    return {job_object(row), false};
}

void Service::Impl::purge(const JobRow& row) {
    auto transaction = store.transaction();
    store.delete_job(row.seq);
    transaction.commit();
    artefacts.forget("job/" + std::to_string(row.seq) + "/");
    remove_film(row.film);
}

void Service::Impl::remove_film(const std::string& film) const {
    if (film.empty()) return;
    remove_quietly(files.films / film);
    for (const ArtefactInfo& artefact : all_artefacts())
        remove_quietly(artefact_path(files.films / film, artefact.name));
}

json Service::Impl::retry_job(const std::string& id) {
    const std::lock_guard lock(mutex);
    JobRow row = require_job(id);
    if (row.state != JobState::Failed && row.state != JobState::Cancelled)
        throw Error(ErrorCode::WrongState, "job " + id + " is " + std::string(job_state_name(row.state)) +
                                               "; only a failed or cancelled one can be retried");
    if (stopping) throw Error(ErrorCode::Unavailable, "the daemon is stopping and takes no new jobs");
    if (!find_scene(row.scene)) throw Error(ErrorCode::WrongState, "the scene of job " + id + " has been deleted");
    if (queue.size() >= options.limits.max_queue)
        throw Error(ErrorCode::QueueFull, std::to_string(queue.size()) + " jobs are waiting, the limit is " +
                                              std::to_string(options.limits.max_queue));
    const std::string old_film = row.film;
    row.state = JobState::Queued;
    row.started_ms.reset();
    row.finished_ms.reset();
    row.crashes = row.losses = 0;
    row.cancel_requested = false;
    row.passes_done = 0;
    row.progress = row.seconds = 0;
    row.film.clear();
    row.artefacts = "[]";
    row.pixel_hash.clear();
    row.statistics.clear();
    row.failure.clear();
    commit_state(row, "queued again on request");
    artefacts.forget("job/" + std::to_string(row.seq) + "/");
    remove_film(old_film);
    json object = job_object(row);
    queue.push(row.seq, row.priority, row.device);
    dispatch();
    return object;
}

}  // namespace photond
