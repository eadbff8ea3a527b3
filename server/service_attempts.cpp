// From the queue to a worker and back. An attempt's number is its fencing token: what comes with another one is
// ignored.

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "protocol/problem.h"
#include "protocol/worker_messages.h"
#include "renderer/methods/registry.h"
#include "server/clock_text.h"
#include "server/row_text.h"
#include "server/service_impl.h"

namespace photond {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr auto kCancelPatience = std::chrono::seconds(4);  // a worker that does not let go of a job by then is killed
constexpr size_t kMaxLogLines = 1000;                      // of one attempt
constexpr size_t kMaxLogLineBytes = 4096;
constexpr uint64_t kJobsBeforeRecycling = 5000;  // of one process

struct NamedEnd {
    AttemptEnd end;
    const char* outcome;
};

NamedEnd end_of(const ProcessExit& exit) {
    switch (exit.cause) {
        case ExitCause::Crashed: return {AttemptEnd::Crashed, "crashed"};
        case ExitCause::Hung: return {AttemptEnd::Crashed, "hung"};
        case ExitCause::OutOfMemory: return {AttemptEnd::OutOfMemory, "out_of_memory"};
        case ExitCause::NoSpace: return {AttemptEnd::NoSpace, "no_space"};
        case ExitCause::DeviceLost: return {AttemptEnd::DeviceLost, "device_lost"};
        case ExitCause::Lost:
        case ExitCause::Ordered: break;
    }
    return {AttemptEnd::Lost, "lost"};
}

void close_attempt(JobRow& row, const RunningAttempt& attempt, const std::string& outcome, const json& reason,
                   int64_t passes_done) {
    json attempts = json::parse(row.attempts);
    if (attempts.empty()) return;
    json& last = attempts.back();
    last["finished"] = rfc3339(now_ms());
    last["outcome"] = outcome;
    last["reason"] = reason;
    last["passes_done"] = passes_done;
    last["device_shared"] = attempt.device_shared;
    last["host_shared"] = attempt.host_shared;
    row.attempts = attempts.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string problem_of(int64_t seq, ErrorCode code, const std::string& detail, const std::vector<Fault>& faults = {}) {
    return problem_json(code, detail, faults, "/v1/jobs/" + job_id(seq))
        .dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace

void Totals::add(const RunningAttempt& attempt) {
    // One whose film could not be gone on with has begun anew, and may not have come as far again.
    const int64_t rendered = std::max<int64_t>(0, attempt.passes_done - attempt.passes_before);
    passes += rendered;
    pixels += rendered * attempt.pixels;
    render_seconds += std::max(0.0, attempt.seconds - attempt.seconds_before);
}

void Totals::add(const RunningAttempt& attempt, const json& rendered) {
    if (!rendered.is_object()) return add(attempt);
    const int64_t count = rendered.value("passes", int64_t{0});
    passes += count;
    pixels += count * attempt.pixels;
    render_seconds += rendered.value("seconds", 0.0);
    photons += rendered.value("photons", uint64_t{0});
    const json traced = rendered.value("rays", json::object());
    for (const auto& [kind, number] : traced.items()) rays[kind] += number.get<uint64_t>();
}

void Service::Impl::ended(const JobRow& row) {
    ++totals.jobs[std::string(job_state_name(row.state))];
    metrics.job_ended(std::string(job_state_name(row.state)), row.method, row.device, row.seconds,
                      parsed_or_null(row.statistics));
    attempt_changed.notify_all();
    release_waiting(row);
}

RunningAttempt* Service::Impl::running_attempt(int64_t seq) {
    Slot* slot = slot_of(seq);
    return slot ? &*slot->running : nullptr;
}

Slot* Service::Impl::slot_of(int64_t seq) {
    for (const auto& slot : slots)
        if (slot->running && slot->running->seq == seq) return slot.get();
    return nullptr;
}

void Service::Impl::dispatch() {
    for (const auto& slot : slots) dispatch(*slot);
}

void Service::Impl::dispatch(Slot& slot) {
    // A job is accepted when its row is there; whatever goes wrong here leaves it queued, to be tried at the next tick.
    try {
        while (!stopping && slot.answered && !slot.running) {
            const auto seq = queue.front(slot.device);
            if (!seq) return;
            auto row = store.job(*seq);
            if (!row || row->state != JobState::Queued) {
                queue.remove(*seq);
            } else if (waits_for(*row)) {  // what it is measured against was queued again
                queue.remove(*seq);
                enqueue(*row);
            } else {
                begin_attempt(slot, *std::move(row));
                queue.remove(*seq);
            }
        }
    } catch (const std::exception& error) {
        spdlog::error("device {}: the next job cannot begin: {}", slot.device, error.what());
    }
}

void Service::Impl::begin_attempt(Slot& slot, JobRow row) {
    json reference;
    try {
        reference = reference_source(row);
    } catch (const Error& error) {
        if (error.code != ErrorCode::WrongState) throw;
        return fail_for_reference(std::move(row), error.what());
    }
    const auto scene = find_scene(row.scene);
    if (!scene) throw Error(ErrorCode::Internal, "job " + job_id(row.seq) + " has lost its scene");
    const json request = json::parse(row.request);
    json environment;
    if (const auto found = request.find("environment"); found != request.end() && found->is_object()) {
        const auto image = store.image(found->value("image", "").substr(6));
        if (!image) throw Error(ErrorCode::Internal, "job " + job_id(row.seq) + " has lost its environment");
        environment = {{"path", (files.images / image->file).string()}};
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
    commit_state(row, "attempt " + std::to_string(row.attempt) + " begins on " + slot.device + from);
    if (first) metrics.job_started(static_cast<double>(now - row.created_ms) / 1000);

    RunningAttempt attempt;
    attempt.seq = row.seq;
    attempt.attempt = row.attempt;
    attempt.film = job_id(row.seq) + "-" + std::to_string(row.attempt) + ".film";
    attempt.pixels = request["image"].value("width", int64_t{0}) * request["image"].value("height", int64_t{0});
    attempt.passes_done = attempt.passes_before = row.passes_done;
    attempt.progress = row.progress;
    attempt.seconds = attempt.seconds_before = row.seconds;
    if (!row.error_now.empty()) attempt.error_now = json::parse(row.error_now);
    if (!row.curve.empty()) attempt.curve = json::parse(row.curve);
    attempt.begun = SteadyClock::now();
    attempt.last_event = attempt.last_curve_event = attempt.begun - kProgressInterval;
    if (options.limits.max_job_seconds > 0)
        attempt.deadline =
            attempt.begun + std::chrono::milliseconds(static_cast<int64_t>(options.limits.max_job_seconds * 1000));
    // Where the process has just died the message is lost; its end is then this attempt's end.
    slot.process->send({{"type", "render"},
                        {"job", job_id(row.seq)},
                        {"attempt", row.attempt},
                        {"request", request},
                        {"scene", scene_order(*scene)},
                        {"environment", environment},
                        {"film", (files.films / attempt.film).string()},
                        {"resume", row.film.empty() ? json() : json((files.films / row.film).string())},
                        {"reference", reference},
                        {"streams", row.role == JobRole::Reference ? "reference" : "job"},
                        {"save_seconds", options.save_seconds > 0 ? json(options.save_seconds) : json()},
                        {"limits", {{"memory_bytes", options.memory_limit_bytes}, {"threads", options.threads}}}});
    slot.running = std::move(attempt);
    mark_shared(slot);
}

void Service::Impl::mark_shared(Slot& slot) {
    for (const auto& other : slots) {
        if (other.get() == &slot || !other->running) continue;
        const bool same_cores = slot.on_host_cores && other->on_host_cores;
        for (RunningAttempt* attempt : {&*slot.running, &*other->running}) {
            attempt->host_shared = true;
            attempt->device_shared = attempt->device_shared || same_cores;
        }
    }
}

void Service::Impl::cancel_running(Slot& slot) {
    slot.running->kill_at = std::min(slot.running->kill_at, SteadyClock::now() + kCancelPatience);
    slot.process->send({{"type", "cancel"}, {"job", job_id(slot.running->seq)}});
}

void Service::Impl::settle(Slot& slot, std::function<void()> record) {
    try {
        record();
    } catch (const std::exception& error) {
        // Nothing is lost: the film is on the disk, and the record is tried again at the next tick.
        spdlog::error("job {}: its end cannot be recorded yet: {}", job_id(slot.running->seq), error.what());
        slot.running->unsettled = std::move(record);
        return;
    }
    slot.running.reset();
    attempt_changed.notify_all();
    if (slot.answered && ++slot.jobs_done >= kJobsBeforeRecycling) {
        slot.answered = false;  // until its successor says hello
        slot.process->recycle();
    }
    dispatch();  // its end may have set others free, for other devices too
}

void Service::Impl::worker_message(Slot& slot, const json& message) {
    const std::string type = message.value("type", "");
    bool hello = false;
    {
        const std::lock_guard lock(mutex);
        try {
            if (type == "hello") {
                hello = slot.answered = true;
                slot.jobs_done = 0;
                slot.device_object = message.value("device", json());
                dispatch(slot);
            } else if (!slot.running || message.value("job", "") != job_id(slot.running->seq) ||
                       message.value("attempt", int64_t{0}) != slot.running->attempt) {
                spdlog::warn("device {}: a late '{}' is ignored", slot.device, type);
            } else if (type == "progress") {
                progress(slot, message);
            } else if (type == "curve") {
                curve(slot, message);
            } else if (type == "film_saved") {
                film_saved(slot, message);
            } else if (type == "device_lost") {
                slot.running->device_lost = message.value("reason", "");
            } else if (type == "finished") {
                finished(slot, message);
            }
        } catch (const std::exception& error) {
            spdlog::error("device {}: '{}' could not be handled: {}", slot.device, type, error.what());
        }
    }
    if (hello) update_ready();
}

void Service::Impl::finished(Slot& slot, const json& message) {
    settle(slot,
           [this, attempt = *slot.running, message, device = slot.device] { record_result(attempt, message, device); });
}

json Service::Impl::kept_artefacts(const JobRow& row, const json& message) const {
    const MethodInfo* method = find_method(row.method);
    json kept = json::array();
    const json names = message.value("artefacts", json::array());
    for (const ArtefactInfo& artefact : method ? method->artefacts : std::vector<ArtefactInfo>())
        if (std::find(names.begin(), names.end(), json(artefact.name)) != names.end() &&
            fs::is_regular_file(fs::symlink_status(artefact_path(files.films / row.film, artefact.name))))
            kept.push_back(artefact.name);
    return kept;
}

namespace {

/// What a film that the attempt left says of the job.
void take_film(JobRow& row, const RunningAttempt& attempt, const json& message) {
    row.film = attempt.film;
    row.passes_done = message.value("passes_done", int64_t{0});
    row.seconds = message.value("seconds", 0.0);
    row.progress = std::max(row.progress, attempt.progress);
    const json points = message.value("curve", json());
    row.curve = text_of(points.is_array() ? points : attempt.curve);
    row.error_now = text_of(object_or_null(message, "error_now"));
}

void take_statistics(JobRow& row, const RunningAttempt& attempt, json statistics) {
    // Of what an earlier attempt left, its record tells.
    const json before = json::parse(row.attempts);
    const auto was_shared = [&](const char* what, bool now) {
        for (const json& earlier : before)
            now = now || (earlier.value("passes_done", 0) > 0 && earlier.value(what, false));
        return now;
    };
    statistics["device_shared"] = was_shared("device_shared", attempt.device_shared);
    statistics["host_shared"] = was_shared("host_shared", attempt.host_shared);
    row.statistics = statistics.dump(-1, ' ', false, json::error_handler_t::replace);
    const json hash = statistics.value("pixel_hash", json());
    row.pixel_hash = hash.is_string() ? hash.get<std::string>() : "";
}

/// How an attempt ended, as its record says it.
struct AttemptOutcome {
    std::string name;
    json reason = nullptr;
};

/// The job's state after it.
AttemptOutcome take_end(JobRow& row, const RunningAttempt& attempt, const json& message, bool has_film,
                        const Limits& limits) {
    const std::string state = message.value("state", "");
    if (state == "succeeded" && has_film) {
        row.state = JobState::Succeeded;
        row.progress = 1;
        return {state};
    }
    if (state == "cancelled" && attempt.deadline_passed) {
        const std::string reason = "passed the limit of " + std::to_string(limits.max_job_seconds) + " s";
        row.state = JobState::Failed;
        row.failure = problem_of(row.seq, ErrorCode::TimedOut, "the job " + reason);
        return {"timed_out", reason};
    }
    if (state == "cancelled" && message.value("stopping", false) && !row.cancel_requested) {
        // The daemon is stopping: its film so far stays with it, and it waits for the next start.
        row.state = JobState::Queued;
        row.finished_ms.reset();
        row.statistics.clear();
        return {"stopped", "the daemon was stopped"};
    }
    if (state == "cancelled") {
        row.state = JobState::Cancelled;
        return {state};
    }
    const Error failure = state == "succeeded" ? Error(ErrorCode::Internal, "the worker left no film")
                                               : error_from_failure(message.value("failure", json()));
    row.state = JobState::Failed;
    row.failure = problem_of(row.seq, failure.code, failure.what(), failure.faults);
    return {"failed", failure.what()};
}

}  // namespace

void Service::Impl::record_result(const RunningAttempt& attempt, const json& message, const std::string& device) {
    auto found = store.job(attempt.seq);
    if (!found || found->state != JobState::Running || found->attempt != attempt.attempt) return;
    JobRow row = *std::move(found);
    const std::string old_film = row.film;
    const json film = message.value("film", json());
    const bool has_film = film.is_string() && fs::path(film.get<std::string>()) == files.films / attempt.film &&
                          fs::is_regular_file(files.films / attempt.film);
    if (has_film) take_film(row, attempt, message);  // else what was saved last stays, and the row says what that holds
    row.finished_ms = now_ms();
    if (json statistics = message.value("statistics", json()); statistics.is_object())
        take_statistics(row, attempt, std::move(statistics));
    const auto [outcome, reason] = take_end(row, attempt, message, has_film, options.limits);
    row.artefacts = is_over(row.state) && has_film ? kept_artefacts(row, message).dump() : "[]";
    const int64_t reached = message.value("passes_done", int64_t{0});
    close_attempt(row, attempt, outcome, reason, reached);
    const std::string line = "attempt " + std::to_string(row.attempt) + " " + outcome + " after " +
                             std::to_string(reached) + " passes" +
                             (reason.is_string() ? ": " + reason.get<std::string>() : "");
    commit_state(
        row, line,
        [&] {
            const json lines = message.value("log", json::array());
            for (size_t i = 0; i < lines.size() && i < kMaxLogLines; ++i)
                if (lines[i].is_string())
                    store.append_log(row.seq, now_ms(), lines[i].get<std::string>().substr(0, kMaxLogLineBytes));
        },
        attempt.unpublished);
    totals.add(attempt, message.value("rendered", json()));
    if (old_film != row.film) remove_film(old_film);
    artefacts.forget("job/" + std::to_string(row.seq) + "/");
    if (row.state == JobState::Queued) return enqueue(row);

    ended(row);
    if (row.purge_requested) purge(row);
    spdlog::info("job {} {} on {} after {} passes, {:.3f} s", job_id(row.seq), outcome, device, row.passes_done,
                 row.seconds);
}

void Service::Impl::record_loss(const RunningAttempt& attempt, const ProcessExit& exit, bool daemon_stopping) {
    auto found = store.job(attempt.seq);
    if (!found || found->state != JobState::Running || found->attempt != attempt.attempt) return;
    JobRow row = *std::move(found);
    std::string reason = attempt.device_lost.empty() ? "the worker " + exit.text : attempt.device_lost;
    NamedEnd end = end_of(exit);
    if (exit.text.starts_with("the daemon")) reason = exit.text;
    // The row says what the film holds that was saved last: that is what the job has, and goes on from.
    std::string outcome = end.outcome;
    if (row.cancel_requested) {
        row.state = JobState::Cancelled;
        outcome = "cancelled";
    } else if (daemon_stopping) {
        row.state = JobState::Queued;
        outcome = "stopped";
        reason = "the daemon was stopped";
    } else {
        if (attempt.deadline_passed) {
            end = {AttemptEnd::TimedOut, "timed_out"};
            outcome = end.outcome;
            reason = "passed the limit of " + std::to_string(options.limits.max_job_seconds) + " s";
        }
        row.losses += end.end == AttemptEnd::Lost;
        row.crashes += end.end == AttemptEnd::Crashed || end.end == AttemptEnd::DeviceLost;
        if (const auto failure = failure_after(end.end, row.losses, row.crashes)) {
            row.state = JobState::Failed;
            row.failure =
                problem_of(row.seq, *failure, "attempt " + std::to_string(row.attempt) + " " + outcome + ": " + reason);
        } else {
            row.state = JobState::Queued;
        }
    }
    if (is_over(row.state)) row.finished_ms = now_ms();
    close_attempt(row, attempt, outcome, reason, attempt.passes_done);
    commit_state(row,
                 "attempt " + std::to_string(row.attempt) + " " + outcome + ": " + reason +
                     (row.state == JobState::Queued ? "; queued again" : ""),
                 {}, attempt.unpublished);
    totals.add(attempt);
    // What the dead attempt had written nobody names, nor what it was writing.
    if (attempt.film != row.film) remove_film(attempt.film);
    remove_parts(attempt.film);
    if (row.state == JobState::Queued) {
        enqueue(row);
    } else {
        ended(row);
        if (row.purge_requested) purge(row);
    }
    spdlog::warn("job {} attempt {} {}: {}", job_id(row.seq), row.attempt, outcome, reason);
}

void Service::Impl::worker_exited(Slot& slot, const ProcessExit& exit) {
    {
        const std::lock_guard lock(mutex);
        slot.answered = false;
        ++slot.restarts;
        if (exit.cause != ExitCause::Ordered) metrics.worker_restarted(std::string(exit_cause_name(exit.cause)));
        // A result that only waits to be recorded is no loss.
        if (slot.running && !slot.running->unsettled)
            settle(slot, [this, attempt = *slot.running, exit, now_stopping = stopping] {
                record_loss(attempt, exit, now_stopping);
            });
    }
    update_ready();
}

void Service::Impl::worker_tick(Slot& slot) {
    const std::lock_guard lock(mutex);
    if (slot.running && slot.running->unsettled) {
        const auto record = slot.running->unsettled;
        settle(slot, record);
    }
    if (!slot.running) return dispatch(slot);
    const auto now = SteadyClock::now();
    RunningAttempt& attempt = *slot.running;
    publish_curve(attempt);
    if (now >= attempt.deadline && !attempt.deadline_passed) {
        attempt.deadline_passed = true;
        cancel_running(slot);
    }
    if (now >= attempt.kill_at) slot.process->kill();
}

}  // namespace photond
