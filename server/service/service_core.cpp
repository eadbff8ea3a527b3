#include "server/service/service_core.h"

#include <algorithm>

#include "server/clock_text.h"
#include "server/job_vocabulary.h"
#include "server/row_text.h"

namespace photond {

using nlohmann::json;

namespace {

constexpr size_t kEventsKept = 20'000;  // in the store, for Last-Event-ID
constexpr uint64_t kEventIdsAhead = 10'000;

Options with_devices_of(DeviceList& list, Options given) {
    given.devices = list.resolve(given.devices);
    return given;
}

}  // namespace

ServiceCore::ServiceCore(Options given)
    : device_list(given.worker_program),
      options(with_devices_of(device_list, std::move(given))),
      files(options.data_dir),
      vocabulary(job_vocabulary()),
      artefacts(options.limits.artefact_cache_bytes),
      store(files.store) {}

void ServiceCore::check_disk(uint64_t bytes) const {
    const uint64_t free = files.free_bytes(), reserve = options.limits.disk_reserve_bytes;
    if (free < reserve || free - reserve < bytes)
        throw Error(ErrorCode::NoSpace, std::to_string(bytes) + " bytes more would leave less than the reserve of " +
                                            std::to_string(reserve) + " bytes; " + std::to_string(free) + " are free");
}

void ServiceCore::note_upload(const std::string& path) {
    const std::lock_guard lock(mutex);
    auto transaction = store.transaction();
    store.note_unnamed_file(path);
    transaction.commit();
}

bool ServiceCore::has_device(const std::string& id) const {
    return std::find(options.devices.begin(), options.devices.end(), id) != options.devices.end();
}

ProcessOptions ServiceCore::process_options() const {
    ProcessOptions process;
    process.program = options.worker_program;
    process.memory_limit_bytes = options.memory_limit_bytes;
    process.priority.nice = options.worker_nice;
    process.heartbeat_timeout_seconds = options.limits.heartbeat_timeout_seconds;
    return process;
}

json ServiceCore::listed_device(const std::string& id) {
    for (json& device : device_list.get())
        if (device.value("id", "") == id) return std::move(device);
    throw Error(ErrorCode::DeviceUnavailable, "this machine has no device " + id + " any more");
}

std::string ServiceCore::device_of(const JobMethod& method, const std::string& pointer) const {
    std::string known;
    for (const std::string& device : options.devices) {
        if (device == method.device || (method.device == "gpu" && device.starts_with("gpu:"))) return device;
        known += (known.empty() ? "" : ", ") + device;
    }
    throw Error(ErrorCode::DeviceUnavailable, pointer,
                "this daemon has no device '" + method.device + "'; it has: " + known);
}

std::string ServiceCore::state_data(const JobRow& row) {
    const json data = {{"id", job_id(row.seq)},
                       {"state", job_state_name(row.state)},
                       {"priority", row.priority},
                       {"progress", row.progress},
                       {"passes_done", row.passes_done},
                       {"seconds", row.seconds},
                       {"error_now", parsed_or_null(row.error_now)},
                       {"started", time_or_null(row.started_ms)},
                       {"finished", time_or_null(row.finished_ms)},
                       {"attempts", json::parse(row.attempts)},
                       {"failure", parsed_or_null(row.failure)},
                       {"statistics", parsed_or_null(row.statistics)}};
    return data.dump(-1, ' ', false, json::error_handler_t::replace);
}

void ServiceCore::put_event(Outbox& outbox, const char* type, int64_t job, std::string data) {
    outbox.events.push_back({events.next_id() + outbox.events.size(), type, job_id(job), std::move(data)});
    if (events.next_id() + outbox.events.size() >= outbox.ids_until)
        outbox.ids_until = reserve_event_ids(outbox.events.size());
    store.insert_event(outbox.events.back(), job);
}

void ServiceCore::tell(Outbox outbox) {
    event_ids_until = std::max(event_ids_until, outbox.ids_until);
    for (Event& event : outbox.events) events.publish(std::move(event));
}

void ServiceCore::commit_state(JobRow& row, const std::string& log_line,
                               const std::function<void(Outbox& outbox)>& more, const json& new_points) {
    Outbox outbox;
    auto transaction = store.transaction();
    store.update_job(row);
    if (more) more(outbox);
    store.append_log(row.seq, now_ms(), log_line);
    if (!new_points.empty()) put_event(outbox, "curve", row.seq, curve_data(row.seq, new_points, row.error_now));
    put_event(outbox, "state", row.seq, state_data(row));
    transaction.commit();
    tell(std::move(outbox));
}

void ServiceCore::open_events() {
    // What earlier runs have given out lies below; no id is given out twice even when the progress events that had them
    // were never stored.
    const uint64_t first = store.event_ids_until();
    event_ids_until = first;
    try {
        auto transaction = store.transaction();
        store.set_event_ids_until(first + kEventIdsAhead);
        store.prune_events(kEventsKept);
        transaction.commit();
        event_ids_until = first + kEventIdsAhead;
    } catch (const Error& error) {
        if (error.code != ErrorCode::NoSpace) throw;  // else they are reserved with the first event
    }
    events.open(first, [this](uint64_t after_id, uint64_t before_id, const std::string& job, size_t limit) {
        const std::lock_guard history_lock(mutex);
        const int64_t seq = job.empty() ? 0 : job_seq(job);
        if (!job.empty() && seq == 0) return std::vector<Event>();
        return store.events(after_id, before_id, seq, limit);
    });
}

uint64_t ServiceCore::reserve_event_ids(uint64_t at_least) {
    if (events.next_id() + at_least < event_ids_until) return event_ids_until;
    store.set_event_ids_until(event_ids_until + kEventIdsAhead);
    store.prune_events(kEventsKept);
    return event_ids_until + kEventIdsAhead;
}

std::string curve_data(int64_t seq, const json& points, const std::string& error_now) {
    return json{{"id", job_id(seq)}, {"curve", points}, {"error_now", parsed_or_null(error_now)}}.dump(
        -1, ' ', false, json::error_handler_t::replace);
}

}  // namespace photond
