#include "server/service/attempts.h"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>

#include "renderer/core/atomic_file.h"
#include "server/clock_text.h"
#include "server/comparisons/report_text.h"
#include "server/service/saved_film.h"

namespace photond {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr uint64_t kDriverBytes = 1ull << 30;  // of a GPU's driver and its compiler, in a worker's own memory
constexpr auto kCancelPatience = std::chrono::seconds(4);  // a worker that does not let go of a job by then is killed
constexpr uint64_t kJobsBeforeRecycling = 5000;            // of one process

bool is_of_attempt(const WorkerMessage& message, const RunningAttempt& attempt) {
    const auto names_it = [&](const auto& told) {
        if constexpr (requires { told.job; })
            return told.job == job_id(attempt.seq) && told.attempt == attempt.attempt;
        else
            return false;
    };
    return std::visit(names_it, message);
}

/// "gpu:0" as "gpu-0.bin".
std::string pipeline_cache_name(std::string device) {
    std::replace(device.begin(), device.end(), ':', '-');
    return device + ".bin";
}

}  // namespace

void Attempts::lost_with_daemon(const JobRow& row) {
    RunningAttempt attempt;
    attempt.seq = row.seq;
    attempt.attempt = row.attempt;
    records_.record_loss(attempt, {ExitCause::Lost, "the daemon ended without warning", true}, false, std::nullopt);
}

void Attempts::start(const ProcessOptions& process) {
    for (const std::string& device : core_.options.devices) start_worker(device, process);
    for (const auto& slot : slots_)  // what a killed worker left half written
        remove_quietly(AtomicFile::part_of(core_.files.pipeline_cache / pipeline_cache_name(slot->device)));
}

void Attempts::start_worker(const std::string& device, ProcessOptions process) {
    slots_.push_back(std::make_unique<Slot>());
    Slot& slot = *slots_.back();
    slot.device = process.device = device;
    if (device != "cpu") {
        slot.device_object = core_.listed_device(device);
        slot.on_host_cores = slot.device_object.value("software", false);
        process.driver_bytes = kDriverBytes;
        if (slot.on_host_cores) process.driver_bytes += slot.device_object.value("memory_bytes", uint64_t{0});
        process.writes.push_back(core_.files.pipeline_cache);
        process.more_arguments = {"--pipeline-cache",
                                  (core_.files.pipeline_cache / pipeline_cache_name(device)).string()};
    }
    slot.process = std::make_unique<WorkerProcess>(
        std::move(process),
        WorkerProcess::Callbacks{.message = [this, &slot](const json& message) { worker_message(slot, message); },
                                 .exited = [this, &slot](const ProcessExit& exit) { worker_exited(slot, exit); },
                                 .tick = [this, &slot] { worker_tick(slot); }});
}

void Attempts::begin_stop(SteadyClock::time_point deadline) {
    for (const auto& slot : slots_) slot->process->begin_stop(deadline);
}

void Attempts::join() {
    for (const auto& slot : slots_) slot->process->join();
}

void Attempts::update_ready() {
    // Called by the helper's thread too, which may run before the lines that fill in `helper` and `slots` are through.
    const std::lock_guard lock(core_.mutex);
    const auto answers = [](const auto& helper) { return helper && helper->ready(); };
    bool all = answers(core_.helper) && answers(core_.bulk_helper) && !core_.stopping;
    for (const auto& slot : slots_) all = all && slot->answered;
    if (all && !core_.ready.exchange(true)) spdlog::info("every process has answered");
    if (!all) core_.ready = false;
}

const RunningAttempt* Attempts::running_attempt(int64_t seq) const {
    const Slot* slot = slot_of(seq);
    return slot ? &*slot->running : nullptr;
}

Slot* Attempts::slot_of(int64_t seq) const {
    for (const auto& slot : slots_)
        if (slot->running && slot->running->seq == seq) return slot.get();
    return nullptr;
}

void Attempts::cancel_running(int64_t seq) {
    if (Slot* slot = slot_of(seq)) cancel_running(*slot);
}

fs::path Attempts::ask_for_snapshot(int64_t seq) {
    Slot& slot = *slot_of(seq);
    RunningAttempt& running = *slot.running;
    const bool is_asked_for = running.snapshot_asked_at == running.passes_done;
    if (!is_asked_for) running.snapshot_asked_at = running.passes_done, ++running.snapshots;
    fs::path path = core_.files.films / (running.film + ".s" + std::to_string(running.snapshots));
    if (!is_asked_for) slot.process->send(message_json(SnapshotMessage{job_id(seq), path}));
    return path;
}

void Attempts::dispatch() {
    for (const auto& slot : slots_) dispatch(*slot);
}

void Attempts::dispatch(Slot& slot) {
    // A job is accepted when its row is there; whatever goes wrong here leaves it queued, to be tried at the next tick.
    try {
        while (!core_.stopping && slot.answered && !slot.running) {
            const auto seq = core_.queue.front(slot.device);
            if (!seq) return;
            auto row = core_.store.job(*seq);
            if (!row || row->state != JobState::Queued) {
                core_.queue.remove(*seq);
            } else if (waiting_.waits_for(*row)) {  // what it is measured against, or follows, was queued again
                core_.queue.remove(*seq);
                waiting_.enqueue(*row);
            } else if (waits_for_quiet(slot, *row)) {
                return;
            } else {
                begin_attempt(slot, *std::move(row));
                core_.queue.remove(*seq);
            }
        }
    } catch (const std::exception& error) {
        spdlog::error("device {}: the next job cannot begin: {}", slot.device, error.what());
    }
}

bool Attempts::waits_for_quiet(Slot& slot, const JobRow& row) {
    const json seconds = json::parse(row.request).value("quiet_machine", json());
    const auto now = SteadyClock::now();
    const bool begins = !slot.waiting || slot.waiting->seq != row.seq;
    if (!seconds.is_number() || !(seconds.get<double>() > 0)) {
        slot.waiting.reset();
        return false;
    }
    if (begins) slot.waiting = QuietWait{row.seq, now};
    const auto log = [&](const std::string& line) {
        auto transaction = core_.store.transaction();
        core_.store.append_log(row.seq, now_ms(), line);
        transaction.commit();
    };
    const bool others_run = std::any_of(slots_.begin(), slots_.end(), [](const auto& other) { return other->running; });
    const std::optional<double> load = quiet_machine_.load(now);
    const double waited = std::chrono::duration<double>(now - slot.waiting->since).count();
    const bool quiet = load && *load <= kQuietLoad && !others_run;
    if (!quiet && waited < seconds.get<double>()) {
        if (begins) log("waits until nothing else runs on the machine, at most " + short_seconds(seconds));
        return true;
    }
    const std::string busy = load ? short_number(100 * *load) + " % of its processors are busy" : "not known to be";
    log(quiet ? "the machine is quiet, after " + short_seconds(waited)
              : "warning: the machine is not quiet after " + short_seconds(waited) + " (" + busy +
                    "): it begins all the same");
    slot.waiting.reset();
    return false;
}

std::string Attempts::waiting_for(int64_t seq, const std::string& device) const {
    if (const auto other = core_.queue.waits_for(seq))
        return "job " + job_id(*other) + ", which it is measured against or follows from";
    const auto slot =
        std::find_if(slots_.begin(), slots_.end(), [&](const auto& other) { return other->device == device; });
    if (slot == slots_.end()) return "a daemon that serves " + device;
    if ((*slot)->waiting && (*slot)->waiting->seq == seq) return "a quiet machine";
    return (*slot)->answered ? "its turn on " + device : "the worker of " + device + " to start";
}

void Attempts::begin_attempt(Slot& slot, JobRow row) {
    std::optional<ReferenceSource> reference;
    try {
        reference = references_.reference_source(row);
    } catch (const Error& error) {
        if (error.code != ErrorCode::WrongState) throw;
        return waiting_.fail_for_reference(std::move(row), error.what());
    }
    const auto scene = scenes_.find_scene(row.scene);
    if (!scene) throw Error(ErrorCode::Internal, "job " + job_id(row.seq) + " has lost its scene");
    const json request = json::parse(row.request);
    std::optional<RenderMessage::Environment> environment;
    if (const auto found = request.find("environment"); found != request.end() && found->is_object()) {
        const auto image = core_.store.image(found->value("image", "").substr(6));
        if (!image) throw Error(ErrorCode::Internal, "job " + job_id(row.seq) + " has lost its environment");
        environment = {core_.files.images / image->file};
    }
    const int64_t now = now_ms();
    const bool first = !row.started_ms;
    row.state = JobState::Running;
    ++row.attempt;
    if (first) row.started_ms = now;
    json attempts = json::parse(row.attempts);
    attempts.push_back({{"attempt", row.attempt},
                        {"device", slot.device},
                        {"started", rfc3339(now)},
                        {"finished", nullptr},
                        {"outcome", "running"},
                        {"reason", nullptr},
                        {"passes_done", row.passes_done}});
    row.attempts = attempts.dump();
    // The token is on the disk before anybody can act under it: after a crash of the daemon it is never used again.
    const std::string from =
        row.film.empty() ? "" : ", going on from a film of " + std::to_string(row.passes_done) + " passes";
    core_.commit_state(row, "attempt " + std::to_string(row.attempt) + " begins on " + slot.device + from);
    if (first) core_.metrics.job_started(static_cast<double>(now - row.created_ms) / 1000);

    RunningAttempt attempt;
    attempt.seq = row.seq;
    attempt.attempt = row.attempt;
    attempt.film = film_name({row.seq, row.attempt});
    attempt.pixels = request["image"].value("width", int64_t{0}) * request["image"].value("height", int64_t{0});
    attempt.passes_done = attempt.passes_before = row.passes_done;
    attempt.progress = row.progress;
    attempt.seconds = attempt.seconds_before = row.seconds;
    if (!row.error_now.empty()) attempt.error_now = json::parse(row.error_now);
    if (!row.curve.empty()) attempt.curve = json::parse(row.curve);
    attempt.begun = SteadyClock::now();
    attempt.last_event = attempt.last_curve_event = attempt.begun - kProgressInterval;
    if (core_.options.limits.max_job_seconds > 0)
        attempt.deadline = attempt.begun +
                           std::chrono::milliseconds(static_cast<int64_t>(core_.options.limits.max_job_seconds * 1000));
    // Where the process has just died the message is lost; its end is then this attempt's end.
    RenderMessage order{.job = job_id(row.seq),
                        .attempt = row.attempt,
                        .request = request,
                        .scene = scenes_.scene_source(*scene),
                        .environment = std::move(environment),
                        .film = core_.files.films / attempt.film,
                        .origin = film_origin(core_.store.id(), AttemptId{row.seq, row.attempt}),
                        .resume = {},
                        .before = FrameOrder(core_).before(row),
                        .reference = std::move(reference),
                        .streams = row.role == JobRole::Reference ? "reference" : "job",
                        .save_seconds = {},
                        .limits = {core_.options.memory_limit_bytes, core_.options.threads}};
    if (!row.film.empty()) order.resume = core_.files.films / row.film;
    if (core_.options.save_seconds > 0) order.save_seconds = core_.options.save_seconds;
    note_processor_time();
    slot.process->send(message_json(std::move(order)));
    slot.running = std::move(attempt);
    if (slot.on_host_cores) ++core_.jobs_on_host_cores;
    mark_shared(slot);
}

void Attempts::mark_shared(Slot& slot) {
    for (const auto& other : slots_) {
        if (other.get() == &slot || !other->running) continue;
        const bool same_cores = slot.on_host_cores && other->on_host_cores;
        for (RunningAttempt* attempt : {&*slot.running, &*other->running}) {
            attempt->host_shared = true;
            attempt->device_shared = attempt->device_shared || same_cores;
        }
    }
}

void Attempts::note_processor_time() {
    std::vector<ProcessMeter::Process> ours{{"photond", getpid()}};
    if (core_.helper) ours.push_back({"helper", core_.helper->pid()});
    if (core_.bulk_helper) ours.push_back({"bulk helper", core_.bulk_helper->pid()});
    if (const Helper* background = pictures_.background()) ours.push_back({"pictures", background->pid()});
    const auto job_of = [](const Slot& slot) { return "job " + job_id(slot.running->seq); };
    for (const auto& slot : slots_)
        ours.push_back({slot->running ? job_of(*slot) : "worker " + slot->device, slot->process->pid()});
    for (const auto& [who, seconds] : meter_.read(ours))
        for (const auto& slot : slots_)
            if (slot->running && who != job_of(*slot)) slot->running->taken[who] += seconds;
}

void Attempts::cancel_running(Slot& slot) {
    slot.running->kill_at = std::min(slot.running->kill_at, SteadyClock::now() + kCancelPatience);
    slot.process->send(message_json(CancelMessage{job_id(slot.running->seq)}));
}

void Attempts::settle(Slot& slot, std::function<void()> record) {
    try {
        record();
    } catch (const std::exception& error) {
        // Nothing is lost: the film is on the disk, and the record is tried again at the next tick.
        spdlog::error("job {}: its end cannot be recorded yet: {}", job_id(slot.running->seq), error.what());
        slot.running->unsettled = std::move(record);
        return;
    }
    slot.running.reset();
    if (slot.on_host_cores) --core_.jobs_on_host_cores;
    core_.attempt_changed.notify_all();
    if (slot.answered && ++slot.jobs_done >= kJobsBeforeRecycling) {
        slot.answered = false;  // until its successor says hello
        slot.process->recycle();
    }
    dispatch();  // its end may have set others free, for other devices too
}

void Attempts::worker_message(Slot& slot, const json& message) {
    // All of it is read before any of it is believed.
    const std::optional<WorkerMessage> told = read_worker_message(message);
    const std::string_view type = type_of_message(message);
    if (!told) return spdlog::warn("device {}: a message of unknown type '{}' is ignored", slot.device, type);
    const auto* hello = std::get_if<HelloMessage>(&*told);
    {
        const std::lock_guard lock(core_.mutex);
        try {
            if (hello) {
                slot.answered = true;
                slot.jobs_done = 0;
                slot.device_object = hello->device;
                dispatch(slot);
            } else if (!slot.running || !is_of_attempt(*told, *slot.running)) {
                spdlog::warn("device {}: a late '{}' is ignored", slot.device, type);
            } else if (const auto* progress = std::get_if<ProgressMessage>(&*told)) {
                progress_.progress(*slot.running, *progress);
            } else if (const auto* curve = std::get_if<CurveMessage>(&*told)) {
                progress_.curve(*slot.running, *curve);
            } else if (const auto* film_saved = std::get_if<FilmSavedMessage>(&*told)) {
                progress_.film_saved(*slot.running, *film_saved);
            } else if (const auto* lost = std::get_if<DeviceLostMessage>(&*told)) {
                slot.running->device_lost = lost->reason;
            } else if (const auto* end = std::get_if<FinishedMessage>(&*told)) {
                finished(slot, *end);
            }
        } catch (const std::exception& error) {
            spdlog::error("device {}: '{}' could not be handled: {}", slot.device, type, error.what());
        }
    }
    if (hello) update_ready();
}

void Attempts::finished(Slot& slot, const FinishedMessage& message) {
    note_processor_time();
    settle(slot, [this, attempt = *slot.running, message, device = slot.device] {
        records_.record_result(attempt, message, device);
    });
}

void Attempts::worker_exited(Slot& slot, const ProcessExit& exit) {
    const std::optional<FilmFacts> left = film_left_in(slot);
    {
        const std::lock_guard lock(core_.mutex);
        slot.answered = false;
        ++slot.restarts;
        if (exit.cause != ExitCause::Ordered) core_.metrics.worker_restarted(std::string(exit_cause_name(exit.cause)));
        // A result that only waits to be recorded is no loss.
        if (slot.running && !slot.running->unsettled)
            settle(slot, [this, attempt = *slot.running, exit, left, now_stopping = core_.stopping] {
                records_.record_loss(attempt, exit, now_stopping, left);
            });
    }
    update_ready();
}

std::optional<FilmFacts> Attempts::film_left_in(const Slot& slot) {
    std::optional<AttemptId> attempt;
    {
        const std::lock_guard lock(core_.mutex);
        if (slot.running && !slot.running->unsettled) attempt = AttemptId{slot.running->seq, slot.running->attempt};
    }
    // Reading all of a large film takes a second. Only this thread gives the slot another attempt.
    return attempt ? saved_film(core_.files, core_.store.id(), *attempt) : std::nullopt;
}

void Attempts::worker_tick(Slot& slot) {
    const std::lock_guard lock(core_.mutex);
    if (slot.running && slot.running->unsettled) {
        const auto record = slot.running->unsettled;
        settle(slot, record);
    }
    if (!slot.running) return dispatch(slot);
    const auto now = SteadyClock::now();
    RunningAttempt& attempt = *slot.running;
    progress_.publish_untold(attempt);
    if (now >= attempt.deadline && !attempt.deadline_passed) {
        attempt.deadline_passed = true;
        cancel_running(slot);
    }
    if (now >= attempt.kill_at) slot.process->kill();
}

}  // namespace photond
