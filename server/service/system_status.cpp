#include "server/service/system_status.h"

#include <unistd.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace photond {

using nlohmann::json;

namespace {

/// A request that somebody waits for takes a helper less; past it the others that wait have no answer.
constexpr double kUnansweredSeconds = 15;

}  // namespace

Page SystemStatus::devices() {
    std::vector<json> items = core_.device_list.get();
    for (json& device : items) device["served"] = false;  // as it is where no worker of ours has it
    const std::lock_guard lock(core_.mutex);
    for (const auto& slot : attempts_.slots()) {
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

json SystemStatus::status() {
    json workers = json::array();
    const std::lock_guard lock(core_.mutex);
    const auto name_of = [](const Slot& slot) {  // known once it has answered
        return slot.device_object.is_object() ? slot.device_object.value("name", json()) : json();
    };
    const auto describe = [this](const std::string& device, json name, const char* state, pid_t pid, json job,
                                 uint64_t restarts, uint64_t resident, const std::optional<FileAccess>& file_access) {
        return json{{"device", device},
                    {"device_name", std::move(name)},
                    {"state", state},
                    {"pid", pid < 0 ? json() : json(pid)},
                    {"job", std::move(job)},
                    {"restarts", restarts},
                    {"resident_bytes", resident},
                    {"memory_limit_bytes", core_.options.memory_limit_bytes},
                    {"file_access", part_json(file_access)}};
    };
    for (const auto& slot : attempts_.slots())
        workers.push_back(describe(slot->device, name_of(*slot),
                                   slot->running    ? "busy"
                                   : slot->answered ? "ready"
                                                    : "failed",
                                   slot->process->pid(), slot->running ? json(job_id(slot->running->seq)) : json(),
                                   slot->restarts, slot->process->resident_bytes(), slot->process->file_access()));
    workers.push_back(describe("none", nullptr, core_.helper->ready() ? "ready" : "failed", core_.helper->pid(),
                               nullptr, core_.helper->restarts(), core_.helper->resident_bytes(),
                               core_.helper->file_access()));
    const double uptime = std::chrono::duration<double>(SteadyClock::now() - core_.begun).count();
    const int64_t running = std::count_if(attempts_.slots().begin(), attempts_.slots().end(),
                                          [](const auto& slot) { return slot->running; });
    return {{"version", PHOTOND_VERSION},
            {"uptime_seconds", uptime},
            {"ready", core_.ready.load()},
            {"queue", {{"queued", core_.queue.size()}, {"running", running}}},
            {"workers", std::move(workers)},
            {"pictures", pictures_now()},
            {"helpers", helpers_now()},
            {"store", upkeep_.status()},
            {"disk_free_bytes", core_.files.free_bytes()},
            {"totals", totals_now()},
            {"resident_bytes", resident_bytes_of(getpid())},
            {"event_clients", core_.metrics.event_clients()}};
}

json SystemStatus::pictures_now() const {
    const Helper* background = pictures_.background();
    const pid_t pid = background ? background->pid() : -1;
    return {{"waiting", pictures_.waiting()},
            {"pid", pid < 0 ? json() : json(pid)},
            {"restarts", background ? background->restarts() : 0},
            {"resident_bytes", background ? background->resident_bytes() : 0},
            {"file_access", part_json(background ? background->file_access() : std::nullopt)}};
}

json SystemStatus::helpers_now() const {
    const auto describe = [](const char* name, const Helper& helper) {
        const auto busy_seconds = helper.busy_seconds();
        return json{{"name", name},
                    {"state", helper.ready() ? busy_seconds ? "busy" : "ready" : "failed"},
                    {"busy_seconds", busy_seconds ? json(*busy_seconds) : json()},
                    {"pid", helper.pid() < 0 ? json() : json(helper.pid())},
                    {"restarts", helper.restarts()},
                    {"resident_bytes", helper.resident_bytes()},
                    {"file_access", part_json(helper.file_access())}};
    };
    return json::array({describe("answers", *core_.helper), describe("bulk", *core_.bulk_helper)});
}

Readiness SystemStatus::readiness() const {
    if (!core_.ready) return {"the daemon is starting or stopping"};
    const double seconds = core_.helper->busy_seconds().value_or(0);
    if (seconds < kUnansweredSeconds) return {};
    return {"the helper that makes images and pictures has not answered for " +
            std::to_string(static_cast<int64_t>(seconds)) + " s"};
}

json SystemStatus::totals_now() const {
    Totals now = core_.totals;
    for (const auto& slot : attempts_.slots())
        if (slot->running) now.add(*slot->running);
    return {{"jobs", now.jobs}, {"passes", now.passes},  {"pixels", now.pixels}, {"render_seconds", now.render_seconds},
            {"rays", now.rays}, {"photons", now.photons}};
}

std::string SystemStatus::metrics_text() {
    {
        const std::lock_guard lock(core_.mutex);
        uint64_t idle = 0, busy = 0, failed = 0;
        for (const Helper* helper : {core_.helper.get(), core_.bulk_helper.get()})
            ++(!helper->ready() ? failed : helper->busy_seconds() ? busy : idle);
        for (const auto& slot : attempts_.slots()) ++(slot->running ? busy : slot->answered ? idle : failed);
        core_.metrics.workers(idle, busy, failed);
        core_.metrics.queue_depth(core_.queue.size());
        core_.metrics.pictures_waiting(pictures_.waiting());
        core_.metrics.disk_free(core_.files.free_bytes());
    }
    return core_.metrics.text();
}

}  // namespace photond
