#include "server/service.h"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <charconv>
#include <nlohmann/json.hpp>

#include "protocol/worker_messages.h"
#include "renderer/methods/registry.h"
#include "renderer/scene/builtin_scenes.h"
#include "server/clock_text.h"
#include "server/job_vocabulary.h"
#include "server/service_impl.h"

namespace photond {

using nlohmann::json;

namespace {

constexpr size_t kEventsKept = 20'000;  // in the store, for Last-Event-ID
constexpr uint64_t kEventIdsAhead = 10'000;
constexpr std::chrono::seconds kPrewarmDelay{5};
constexpr uint64_t kDriverBytes = 1ull << 30;  // of a GPU's driver and its compiler, in a worker's own memory

uint64_t milliseconds_until(SteadyClock::time_point begun) {
    return static_cast<uint64_t>(
        std::chrono::duration_cast<std::chrono::milliseconds>(SteadyClock::now() - begun).count());
}

Options with_devices_of(DeviceList& list, Options given) {
    given.devices = list.resolve(given.devices);
    return given;
}

/// "gpu:0" as "gpu-0.bin".
std::string pipeline_cache_name(std::string device) {
    std::replace(device.begin(), device.end(), ':', '-');
    return device + ".bin";
}

}  // namespace

void check_limit(uint32_t limit) {
    if (limit < 1 || limit > 1000)
        throw Error(ErrorCode::OutOfRange, "/limit", "limit = " + std::to_string(limit) + " is outside [1, 1000]");
}

int64_t read_cursor(const std::string& cursor, int64_t otherwise) {
    if (cursor.empty()) return otherwise;
    int64_t value = 0;
    const auto [end, error] = std::from_chars(cursor.data(), cursor.data() + cursor.size(), value);
    if (error != std::errc() || end != cursor.data() + cursor.size() || value < 0)
        throw Error(ErrorCode::OutOfRange, "/cursor", "'" + cursor + "' is no cursor of this list");
    return value;
}

Service::Impl::Impl(Options given)
    : device_list(given.worker_program),
      options(with_devices_of(device_list, std::move(given))),
      files(options.data_dir),
      vocabulary(job_vocabulary()),
      artefacts(options.limits.artefact_cache_bytes),
      store(files.store) {
    recover();
    sweep_orphans();
    start_processes();
    spdlog::info("store open after {} ms, {} jobs queued", milliseconds_until(begun), queue.size());
}

Service::Impl::~Impl() { stop(); }

void Service::Impl::recover() {
    const std::lock_guard lock(mutex);
    // What earlier runs have given out lies below; no id is given out twice even when the progress events that had them
    // were never stored.
    const uint64_t first = store.event_ids_until();
    {
        auto transaction = store.transaction();
        store.set_event_ids_until(first + kEventIdsAhead);
        store.prune_events(kEventsKept);
        transaction.commit();
        event_ids_until = first + kEventIdsAhead;
    }
    events.open(first, [this](uint64_t after_id, uint64_t before_id, const std::string& job, size_t limit) {
        const std::lock_guard history_lock(mutex);
        const int64_t seq = job.empty() ? 0 : job_seq(job);
        if (!job.empty() && seq == 0) return std::vector<Event>();
        return store.events(after_id, before_id, seq, limit);
    });
    for (const JobRow& row : store.running_jobs()) {
        RunningAttempt attempt;
        attempt.seq = row.seq;
        attempt.attempt = row.attempt;
        record_loss(attempt, {ExitCause::Lost, "the daemon ended without warning", true}, false);
    }
    for (const JobRow& row : store.jobs_to_purge()) purge(row);
    finish_purges();
    std::map<std::string, size_t> without_device;  // they are kept for a daemon that has it
    for (const QueuedJob& job : store.queued_jobs()) {
        if (job.waits_for)
            queue.hold(job.seq, job.priority, job.device, *job.waits_for);
        else
            queue.push(job.seq, job.priority, job.device);
        if (!has_device(job.device)) ++without_device[job.device];
    }
    for (const auto& [device, jobs] : without_device)
        spdlog::warn("{} jobs wait for device {}, which this daemon was not given (--devices)", jobs, device);
}

void Service::Impl::sweep_orphans() {
    const std::lock_guard lock(mutex);
    const auto as_set = [](std::vector<std::string> names) {
        return std::unordered_set<std::string>(names.begin(), names.end());
    };
    std::vector<std::string> named = store.films();
    for (const auto& [film, names] : store.artefacts())
        for (const json& name : json::parse(names))
            named.push_back(artefact_path(film, name.get<std::string>()).string());
    const size_t films = DataFiles::sweep(files.films, as_set(std::move(named)));
    const size_t scenes = DataFiles::sweep(files.scenes, as_set(store.scene_ids()));
    const size_t images = DataFiles::sweep(files.images, as_set(store.image_files()));
    if (films + scenes + images > 0)
        spdlog::info("removed what no row names: {} films, {} scenes, {} images", films, scenes, images);
}

void Service::Impl::start_processes() {
    ProcessOptions process;
    process.program = options.worker_program;
    process.memory_limit_bytes = options.memory_limit_bytes;
    process.nice = options.worker_nice;
    process.heartbeat_timeout_seconds = options.limits.heartbeat_timeout_seconds;

    const auto helper_exited = [this](const ProcessExit& exit) {
        update_ready();
        if (exit.cause != ExitCause::Ordered) metrics.worker_restarted(std::string(exit_cause_name(exit.cause)));
    };
    // Callbacks come from threads that start here; they take the lock, and so see what is built below whole.
    const std::lock_guard lock(mutex);
    process.device = "none";
    process.nice = std::max(0, options.worker_nice - 2);  // people wait for it
    helper = std::make_unique<Helper>(
        process, options.limits.helper_timeout_seconds, [this] { update_ready(); }, helper_exited);
    process.nice = options.worker_nice;
    process.threads = options.threads;
    std::unordered_set<std::string> caches;
    for (const std::string& device : options.devices) {
        slots.push_back(std::make_unique<Slot>());
        Slot& slot = *slots.back();
        slot.device = process.device = device;
        process.more_arguments.clear();
        process.driver_bytes = 0;
        if (device != "cpu") {
            slot.device_object = listed_device(device);
            slot.on_host_cores = slot.device_object.value("software", false);
            process.driver_bytes = kDriverBytes;
            if (slot.on_host_cores) process.driver_bytes += slot.device_object.value("memory_bytes", uint64_t{0});
            caches.insert(pipeline_cache_name(device));
            process.more_arguments = {"--pipeline-cache",
                                      (files.pipeline_cache / pipeline_cache_name(device)).string()};
        }
        slot.process = std::make_unique<WorkerProcess>(
            process,
            WorkerProcess::Callbacks{.message = [this, &slot](const json& message) { worker_message(slot, message); },
                                     .exited = [this, &slot](const ProcessExit& exit) { worker_exited(slot, exit); },
                                     .tick = [this, &slot] { worker_tick(slot); }});
    }
    if (!caches.empty()) DataFiles::sweep(files.pipeline_cache, caches);  // what a killed worker left half written
    prewarm = std::thread([this] {
        // Half a second of processor time, which a first job would miss.
        std::unique_lock lock(mutex);
        if (attempt_changed.wait_for(lock, kPrewarmDelay, [this] { return stopping; })) return;
        lock.unlock();
        try {
            for (const std::string_view name : builtin_scene_names()) builtin_object(std::string(name));
        } catch (const std::exception& error) {
            spdlog::warn("built-in scenes are judged later: {}", error.what());  // when somebody asks for one
        }
    });
}

void Service::Impl::stop() {
    std::call_once(stopped, [this] {
        const auto grace =
            std::chrono::milliseconds(static_cast<int64_t>(options.limits.shutdown_grace_seconds * 1000));
        // The rest of the grace time is for what comes after the workers.
        const auto deadline = SteadyClock::now() + grace * 3 / 4;
        {
            const std::lock_guard lock(mutex);
            stopping = true;
            ready = false;
            for (const auto& slot : slots) slot->process->begin_stop(deadline);
        }
        attempt_changed.notify_all();
        if (helper) helper->begin_stop(deadline);
        for (const auto& slot : slots) slot->process->join();
        if (helper) helper->join();
        if (prewarm.joinable()) prewarm.join();
        spdlog::info("all processes have ended");
    });
}

void Service::Impl::update_ready() {
    // Called by the helper's thread too, which may run before the lines that fill in `helper` and `slots` are through.
    const std::lock_guard lock(mutex);
    bool all = helper && helper->ready() && !stopping;
    for (const auto& slot : slots) all = all && slot->answered;
    if (all && !ready.exchange(true)) spdlog::info("every process has answered");
    if (!all) ready = false;
}

bool Service::Impl::has_device(const std::string& id) const {
    return std::find(options.devices.begin(), options.devices.end(), id) != options.devices.end();
}

json Service::Impl::listed_device(const std::string& id) {
    for (json& device : device_list.get())
        if (device.value("id", "") == id) return std::move(device);
    throw Error(ErrorCode::DeviceUnavailable, "this machine has no device " + id + " any more");
}

Page Service::Impl::devices() {
    std::vector<json> items = device_list.get();
    for (json& device : items) device["served"] = false;  // as it is where no worker of ours has it
    const std::lock_guard lock(mutex);
    for (const auto& slot : slots) {
        json device = slot->device_object;
        if (!device.is_object())  // it has not answered yet
            device = {{"id", slot->device},      {"kind", "cpu"},    {"name", nullptr},        {"driver", nullptr},
                      {"memory_bytes", nullptr}, {"software", true}, {"lacks", json::array()}, {"limits", nullptr}};
        device["served"] = true;
        const bool starting = slot->restarts == 0 && !slot->answered;
        device["state"] = slot->running || starting ? "busy" : slot->answered ? "ready" : "failed";
        const auto listed =
            std::find_if(items.begin(), items.end(), [&](const json& item) { return item["id"] == slot->device; });
        if (listed != items.end())
            *listed = std::move(device);
        else
            items.push_back(std::move(device));
    }
    return {{"items", std::move(items)}, {"next_cursor", nullptr}};
}

json Service::Impl::status() {
    json workers = json::array();
    const std::lock_guard lock(mutex);
    const auto name_of = [](const Slot& slot) {  // known once it has answered
        return slot.device_object.is_object() ? slot.device_object.value("name", json()) : json();
    };
    const auto describe = [this](const std::string& device, json name, const char* state, pid_t pid, json job,
                                 uint64_t restarts, uint64_t resident) {
        return json{{"device", device},
                    {"device_name", std::move(name)},
                    {"state", state},
                    {"pid", pid < 0 ? json() : json(pid)},
                    {"job", std::move(job)},
                    {"restarts", restarts},
                    {"resident_bytes", resident},
                    {"memory_limit_bytes", options.memory_limit_bytes}};
    };
    for (const auto& slot : slots)
        workers.push_back(describe(slot->device, name_of(*slot),
                                   slot->running    ? "busy"
                                   : slot->answered ? "ready"
                                                    : "failed",
                                   slot->process->pid(), slot->running ? json(job_id(slot->running->seq)) : json(),
                                   slot->restarts, slot->process->resident_bytes()));
    workers.push_back(describe("none", nullptr, helper->ready() ? "ready" : "failed", helper->pid(), nullptr,
                               helper->restarts(), helper->resident_bytes()));
    const double uptime = std::chrono::duration<double>(SteadyClock::now() - begun).count();
    const int64_t running = std::count_if(slots.begin(), slots.end(), [](const auto& slot) { return slot->running; });
    return {{"version", PHOTOND_VERSION},
            {"uptime_seconds", uptime},
            {"ready", ready.load()},
            {"queue", {{"queued", queue.size()}, {"running", running}}},
            {"workers", std::move(workers)},
            {"disk_free_bytes", files.free_bytes()},
            {"totals", totals_now()},
            {"resident_bytes", resident_bytes_of(getpid())},
            {"event_clients", metrics.event_clients()}};
}

json Service::Impl::totals_now() const {
    Totals now = totals;
    for (const auto& slot : slots)
        if (slot->running) now.add(*slot->running);
    return {{"jobs", now.jobs}, {"passes", now.passes},  {"pixels", now.pixels}, {"render_seconds", now.render_seconds},
            {"rays", now.rays}, {"photons", now.photons}};
}

std::string Service::Impl::metrics_text() {
    {
        const std::lock_guard lock(mutex);
        uint64_t idle = helper->ready() ? 1 : 0, busy = 0, failed = 1 - idle;
        for (const auto& slot : slots) ++(slot->running ? busy : slot->answered ? idle : failed);
        metrics.workers(idle, busy, failed);
        metrics.queue_depth(queue.size());
        metrics.disk_free(files.free_bytes());
    }
    return metrics.text();
}

uint64_t Service::Impl::reserve_event_ids(uint64_t at_least) {
    if (events.next_id() + at_least < event_ids_until) return event_ids_until;
    store.set_event_ids_until(event_ids_until + kEventIdsAhead);
    store.prune_events(kEventsKept);
    return event_ids_until + kEventIdsAhead;
}

Service::Service(Options options) : impl_(std::make_unique<Impl>(std::move(options))) {}
Service::~Service() = default;

std::filesystem::path Service::make_spool_path() { return impl_->files.fresh_spool_path(); }
void Service::check_disk(uint64_t bytes) const { impl_->check_disk(bytes); }
Added Service::add_scene(SceneUpload upload) { return impl_->add_scene(std::move(upload)); }
Page Service::list_scenes(const std::string& family, uint32_t limit, const std::string& cursor) {
    return impl_->list_scenes(family, limit, cursor);
}
json Service::get_scene(const std::string& id_or_name) { return impl_->get_scene(id_or_name); }
Artefact Service::thumbnail(const std::string& id_or_name) { return impl_->thumbnail(id_or_name); }
Artefact Service::baked_scene(const std::string& id_or_name) { return impl_->baked_scene(id_or_name); }
json Service::delete_scene(const std::string& id_or_name) { return impl_->delete_scene(id_or_name); }
Added Service::add_image(const std::filesystem::path& spooled, const std::string& media_type) {
    return impl_->add_image(spooled, media_type);
}
const JobVocabulary& Service::vocabulary() const { return impl_->vocabulary; }
json Service::submit_job(const JobRequest& request, const std::optional<std::string>& idempotency_key,
                         const std::string& canonical_body) {
    return impl_->submit_job(request, idempotency_key, canonical_body);
}
json Service::estimate_job(const JobRequest& request) { return impl_->estimate_job(request); }
json Service::get_job(const std::string& id) { return impl_->get_job(id); }
Page Service::list_jobs(const JobFilter& filter) { return impl_->list_jobs(filter); }
Service::Cancelled Service::cancel_job(const std::string& id) { return impl_->cancel_job(id, false); }
Service::Cancelled Service::purge_job(const std::string& id) { return impl_->cancel_job(id, true); }
json Service::change_job(const std::string& id, const json& body) { return impl_->change_job(id, body); }
json Service::retry_job(const std::string& id) { return impl_->retry_job(id); }
json Service::extend_job(const std::string& id, const json& body) { return impl_->extend_job(id, body); }
json Service::merge_jobs(const json& body, const std::optional<std::string>& idempotency_key) {
    return impl_->merge_jobs(body, idempotency_key);
}
json Service::measure(const json& body) { return impl_->measure(body); }
Artefact Service::curve(const std::string& id) { return impl_->curve_file(id); }
Artefact Service::statistics(const std::string& id) { return impl_->statistics(id); }
Artefact Service::method_artefact(const std::string& id, const std::string& name) {
    return impl_->method_artefact(id, name);
}
Artefact Service::log(const std::string& id) { return impl_->log(id); }
Page Service::devices() { return impl_->devices(); }
json Service::status() { return impl_->status(); }
bool Service::ready() const { return impl_->ready; }
std::string Service::metrics_text() { return impl_->metrics_text(); }
EventHub& Service::events() { return impl_->events; }
Metrics& Service::metrics() { return impl_->metrics; }
const Options& Service::options() const { return impl_->options; }
void Service::stop() { impl_->stop(); }

}  // namespace photond
