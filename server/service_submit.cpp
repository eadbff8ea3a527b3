// A request judged by all that this daemon knows, and the job that follows from it written, told and queued.

#include <spdlog/spdlog.h>

#include <algorithm>

#include "protocol/nearest_name.h"
#include "protocol/param_json.h"
#include "renderer/core/sha256.h"
#include "renderer/methods/registry.h"
#include "renderer/scene/builtin_scenes.h"
#include "server/clock_text.h"
#include "server/device_memory.h"
#include "server/service_impl.h"

namespace photond {

using nlohmann::json;

namespace {

constexpr size_t kMaxKeyBytes = 255;

std::string nearest_hint(const std::string& wrong, const std::vector<std::string>& known) {
    const std::string near = nearest_name(wrong, known);
    return near.empty() ? "" : "; did you mean '" + near + "'?";
}

}  // namespace

void check_idempotency_key(const std::string& key) {
    const bool printable = std::all_of(key.begin(), key.end(), [](char c) { return c > 31 && c < 127; });
    if (key.empty() || key.size() > kMaxKeyBytes || !printable)
        throw Error(ErrorCode::OutOfRange,
                    "an Idempotency-Key has 1 to " + std::to_string(kMaxKeyBytes) + " printable ASCII characters");
}

std::string Service::Impl::device_of(const JobMethod& method, const std::string& pointer) const {
    std::string known;
    for (const std::string& device : options.devices) {
        if (device == method.device || (method.device == "gpu" && device.starts_with("gpu:"))) return device;
        known += (known.empty() ? "" : ", ") + device;
    }
    throw Error(ErrorCode::DeviceUnavailable, pointer,
                "this daemon has no device '" + method.device + "'; it has: " + known);
}

void Service::Impl::check_parameters(const JobMethod& method, const std::string& prefix) {
    const MethodInfo* info = find_method(method.name);
    if (!info || method.device == "cpu") return;
    const std::unique_ptr<MethodParams> params = info->make_params();
    std::vector<Fault> faults;  // none: the reader of jobs has seen to that
    read_params(*params, method.parameters, "/method/parameters", faults);
    try {
        info->check_gpu(*params);
    } catch (const Error& error) {
        faults = error.faults;
        for (Fault& fault : faults) fault.pointer.insert(0, prefix);
        throw Error(error.code, error.what(), std::move(faults));
    }
}

Service::Impl::SceneRef Service::Impl::check_request(const JobRequest& request) {
    device_of(request.method);
    check_parameters(request.method, "");
    auto scene = find_scene(request.scene);
    if (!scene) {
        std::vector<std::string> known;
        for (const std::string_view name : builtin_scene_names()) known.emplace_back(name);
        for (const std::string_view family : builtin_family_names())
            for (const std::string_view name : builtin_scene_names(family)) known.emplace_back(name);
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
    check_size(request, *scene, "/image");
    check_device_memory(request, *scene, "/image");
    check_reference(request, *scene);
    return *std::move(scene);
}

void Service::Impl::check_size(const JobRequest& request, const SceneRef& scene, const std::string& pointer) {
    const uint64_t bytes = estimate_memory_bytes(request, scene);
    const std::string needs = "; the job needs about " + std::to_string(bytes) + " bytes";
    const uint64_t pixels = uint64_t{request.width} * request.height;
    if (pixels > options.limits.max_pixels)
        throw Error(ErrorCode::OutOfRange, pointer,
                    std::to_string(request.width) + " x " + std::to_string(request.height) + " = " +
                        std::to_string(pixels) + " pixels, the limit is " + std::to_string(options.limits.max_pixels) +
                        needs);
    if (bytes > options.memory_limit_bytes)
        throw Error(ErrorCode::OutOfMemory, pointer,
                    "the limit of a worker is " + std::to_string(options.memory_limit_bytes) + " bytes" + needs);
}

void Service::Impl::check_device_memory(const JobRequest& request, const SceneRef& scene, const std::string& pointer) {
    const auto bytes = estimate_device_bytes(request, scene);
    if (!bytes) return;
    const std::string id = device_of(request.method);
    const json device = listed_device(id);
    const uint64_t limit = job_device_limit_bytes(device_limit_bytes(
        device.value("memory_bytes", uint64_t{0}), device.value("software", false), options.memory_limit_bytes));
    if (*bytes > limit)
        throw Error(ErrorCode::OutOfMemory, pointer,
                    "a job may hold " + std::to_string(limit) + " bytes of " + id + " (" + device.value("name", "") +
                        "); this one needs about " + std::to_string(*bytes));
}

void Service::Impl::check_room(size_t jobs, uint64_t disk_bytes) const {
    if (stopping) throw Error(ErrorCode::Unavailable, "the daemon is stopping and takes no new jobs");
    if (queue.size() + jobs > options.limits.max_queue)
        throw Error(ErrorCode::QueueFull, std::to_string(queue.size()) + " jobs are waiting, the limit is " +
                                              std::to_string(options.limits.max_queue));
    check_disk(disk_bytes);
}

void Service::Impl::check_room(std::span<const PreparedJob> jobs) const {
    uint64_t disk_bytes = 0;
    size_t number = jobs.size();
    std::vector<std::string> contents;  // each reference is made once
    for (const PreparedJob& job : jobs) {
        disk_bytes += job.disk_bytes;
        if (!job.reference || std::find(contents.begin(), contents.end(), job.reference->content) != contents.end())
            continue;
        contents.push_back(job.reference->content);
        disk_bytes += job.reference_disk_bytes;
        ++number;
    }
    check_room(number, disk_bytes);
}

PreparedJob Service::Impl::prepare_job(const JobRequest& request) {
    const SceneRef scene = check_request(request);
    PreparedJob job;
    job.row.priority = request.priority;
    job.row.device = device_of(request.method);
    job.row.method = request.method.name;
    job.row.scene = scene.id;
    job.row.request = to_json(request).dump();
    job.row.created_ms = now_ms();
    if (request.reference && !request.reference->job.empty()) job.row.reference_job = job_seq(request.reference->job);
    job.disk_bytes = estimate_disk_bytes(request, scene);
    job.reference = missing_reference(request, scene, job.row.reference_job);
    if (job.reference) job.reference_disk_bytes = estimate_disk_bytes(reference_request(request), scene);
    return job;
}

void Service::Impl::insert_job(PreparedJob& job, Insertion& inserted) {
    if (job.reference) job.row.reference_job = insert_reference(*job.reference, inserted);
    if (job.row.reference_job) raise_reference(*job.row.reference_job, job.row.priority, inserted);
    store.insert_job(job.row);
    store.append_log(job.row.seq, job.row.created_ms, "queued for " + job.row.device + waiting_text(job.row));
    put_event(inserted.outbox, "state", job.row.seq, state_data(job.row));
    inserted.rows.push_back(job.row);
}

void Service::Impl::accept(Insertion inserted) {
    tell(std::move(inserted.outbox));
    for (const JobRow& row : inserted.rows) {
        queue.remove(row.seq);  // one whose priority rose
        enqueue(row);
    }
    dispatch();
}

json Service::Impl::submit_job(const JobRequest& request, const std::optional<std::string>& key,
                               const std::string& canonical_body) {
    const std::string body_sha256 = key ? sha256_hex(canonical_body.data(), canonical_body.size()) : "";
    if (key) check_idempotency_key(*key);
    know_scene(request.scene);
    const std::lock_guard lock(mutex);
    if (key)
        if (const auto known = job_of_key(*key, body_sha256)) return job_object(*known);
    if (stopping) throw Error(ErrorCode::Unavailable, "the daemon is stopping and takes no new jobs");
    PreparedJob job = prepare_job(request);
    check_room({&job, 1});
    Insertion inserted;
    {
        auto transaction = store.transaction();
        insert_job(job, inserted);
        if (key) store.insert_key(*key, body_sha256, job.row.seq, job.row.created_ms);
        transaction.commit();
    }
    json object = job_object(job.row);  // as accepted, whatever happens next
    accept(std::move(inserted));
    return object;
}

std::optional<JobRow> Service::Impl::job_of_key(const std::string& key, const std::string& body_sha256) {
    const auto known = store.key(key);
    if (!known) return std::nullopt;
    if (known->body_sha256 != body_sha256)
        throw Error(ErrorCode::IdempotencyMismatch,
                    "the Idempotency-Key was used with another body, for job " + job_id(known->job));
    return require_job(job_id(known->job));
}

}  // namespace photond
