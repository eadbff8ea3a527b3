#include "server/service/attempt_records.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "protocol/problem.h"
#include "server/clock_text.h"
#include "server/queue/retry_policy.h"
#include "server/row_text.h"
#include "server/service/artefact_files.h"

namespace photond {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr size_t kMaxLogLines = 1000;  // of one attempt
constexpr size_t kMaxLogLineBytes = 4096;

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

/// What a film that the attempt left says of the job.
void take_film(JobRow& row, const RunningAttempt& attempt, const FinishedMessage& message) {
    row.film = attempt.film;
    row.passes_done = message.passes_done;
    row.seconds = message.seconds;
    row.progress = std::max(row.progress, attempt.progress);
    row.curve = text_of(message.curve.is_array() ? message.curve : attempt.curve);
    row.error_now = text_of(part_json(message.error_now));
}

void take_statistics(JobRow& row, const RunningAttempt& attempt, json statistics, const std::optional<CoreUse>& cores) {
    // Of what an earlier attempt left, its record tells.
    const json before = json::parse(row.attempts);
    const auto was_shared = [&](const char* what, bool now) {
        for (const json& earlier : before)
            now = now || (earlier.value("passes_done", 0) > 0 && earlier.value(what, false));
        return now;
    };
    statistics["device_shared"] = was_shared("device_shared", attempt.device_shared);
    statistics["host_shared"] = was_shared("host_shared", attempt.host_shared);
    statistics["cores"] = part_json(cores);
    statistics["shared"] = to_json(cores ? CoreLoss::of(*cores, attempt.taken) : std::nullopt);
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
AttemptOutcome take_end(JobRow& row, const RunningAttempt& attempt, const FinishedMessage& message, bool has_film,
                        const Limits& limits) {
    const std::string& state = message.state;
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
    if (state == "cancelled" && message.stopping && !row.cancel_requested) {
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
    const Error failure =
        state == "succeeded" ? Error(ErrorCode::Internal, "the worker left no film") : error_of(message.failure);
    row.state = JobState::Failed;
    row.failure = problem_of(row.seq, failure.code, failure.what(), failure.faults);
    return {"failed", failure.what()};
}

}  // namespace

json AttemptRecords::kept_artefacts(const JobRow& row, const std::vector<std::string>& names) const {
    json kept = json::array();
    for (const std::string& name : artefacts_beside(core_.files.films / row.film, row.method))
        if (std::find(names.begin(), names.end(), name) != names.end()) kept.push_back(name);
    return kept;
}

std::vector<std::string> AttemptRecords::inherit_artefacts(const JobRow& before, const RunningAttempt& attempt) const {
    auto names = json::parse(before.artefacts).get<std::vector<std::string>>();
    for (const std::string& name : names) {
        const fs::path from = artefact_path(core_.files.films / before.film, name);
        const fs::path to = artefact_path(core_.files.films / attempt.film, name);
        remove_quietly(to);  // of an earlier try to record this
        link_or_copy(from, to);
    }
    return names;
}

void AttemptRecords::record_result(const RunningAttempt& attempt, const FinishedMessage& message,
                                   const std::string& device) {
    auto found = core_.store.job(attempt.seq);
    if (!found || found->state != JobState::Running || found->attempt != attempt.attempt) return;
    JobRow row = *std::move(found);
    const std::string old_film = row.film;
    const fs::path film = core_.files.films / attempt.film;
    const bool has_film = message.film == film && fs::is_regular_file(film);
    std::vector<std::string> artefacts = message.artefacts;
    const bool nothing_rendered = has_film && message.rendered && message.rendered->passes == 0;
    if (nothing_rendered && row.film != attempt.film) artefacts = inherit_artefacts(row, attempt);
    if (has_film) take_film(row, attempt, message);  // else what was saved last stays, and the row says what that holds
    row.finished_ms = now_ms();
    if (message.statistics.is_object()) take_statistics(row, attempt, message.statistics, message.cores);
    const auto [outcome, reason] = take_end(row, attempt, message, has_film, core_.options.limits);
    if (has_film) row.artefacts = kept_artefacts(row, artefacts).dump();
    close_attempt(row, attempt, outcome, reason, message.passes_done);
    const std::string line = "attempt " + std::to_string(row.attempt) + " " + outcome + " after " +
                             std::to_string(message.passes_done) + " passes" +
                             (reason.is_string() ? ": " + reason.get<std::string>() : "");
    const std::optional<CoreLoss> loss = CoreLoss::of_statistics(parsed_or_null(row.statistics));
    std::optional<JobRow> repeat;
    core_.commit_state(
        row, line,
        [&](Outbox& outbox) {
            for (size_t i = 0; i < message.log.size() && i < kMaxLogLines; ++i)
                core_.store.append_log(row.seq, now_ms(), message.log[i].substr(0, kMaxLogLineBytes));
            if (loss) core_.store.append_log(row.seq, now_ms(), "warning: " + loss->warning());
            if (old_film != row.film) purges_.note_removal(old_film);
            repeat = repeats_.repeat_if_disturbed(row, outbox);
        },
        attempt.unpublished);
    core_.totals.add(attempt, message.rendered);
    if (old_film != row.film) purges_.remove_film(old_film);
    core_.artefacts.forget("job/" + std::to_string(row.seq) + "/");
    if (row.state == JobState::Queued) return waiting_.enqueue(row);

    if (repeat) waiting_.enqueue(*repeat);
    waiting_.ended(row);
    if (row.purge_requested) purges_.purge(row);
    spdlog::info("job {} {} on {} after {} passes, {:.3f} s", job_id(row.seq), outcome, device, row.passes_done,
                 row.seconds);
}

void AttemptRecords::record_loss(const RunningAttempt& attempt, const ProcessExit& exit, bool daemon_stopping,
                                 const std::optional<FilmFacts>& left) {
    auto found = core_.store.job(attempt.seq);
    if (!found || found->state != JobState::Running || found->attempt != attempt.attempt) return;
    JobRow row = *std::move(found);
    std::string reason = attempt.device_lost.empty() ? "the worker " + exit.text : attempt.device_lost;
    NamedEnd end = end_of(exit);
    if (exit.text.starts_with("the daemon")) reason = exit.text;
    // The row says what the film holds that was saved last: that is what the job has, and goes on from.
    const std::string old_film = row.film;
    if (left) take_saved_film(row, *left, core_.files);
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
            reason = "passed the limit of " + std::to_string(core_.options.limits.max_job_seconds) + " s";
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
    const auto note_removal = [&](Outbox&) {
        if (old_film != row.film) purges_.note_removal(old_film);
    };
    core_.commit_state(row,
                       "attempt " + std::to_string(row.attempt) + " " + outcome + ": " + reason +
                           (row.state == JobState::Queued ? "; queued again" : ""),
                       note_removal, attempt.unpublished);
    core_.totals.add(attempt);
    if (old_film != row.film) purges_.remove_film(old_film);
    // What the dead attempt was writing, and artefacts of a film that it did not come to write. A film that cannot be
    // told stays for the next start to judge.
    if (!attempt.film.empty() && !fs::exists(core_.files.films / attempt.film)) purges_.remove_film(attempt.film);
    purges_.remove_parts(attempt.film);
    if (row.state == JobState::Queued) {
        waiting_.enqueue(row);
    } else {
        waiting_.ended(row);
        if (row.purge_requested) purges_.purge(row);
    }
    spdlog::warn("job {} attempt {} {}: {}", job_id(row.seq), row.attempt, outcome, reason);
}

void AttemptRecords::keep_film(const RunningAttempt& attempt, int64_t passes_done) {
    auto row = core_.store.job(attempt.seq);
    if (!row || row->state != JobState::Running || row->attempt != attempt.attempt) return;
    const std::string old_film = std::exchange(row->film, attempt.film);
    // It got further: what happened to attempts before says nothing against those that go on from here.
    if (passes_done > row->passes_done) row->losses = row->crashes = 0;
    row->passes_done = passes_done;
    row->seconds = attempt.seconds;
    row->progress = attempt.progress;
    row->curve = text_of(attempt.curve);
    row->error_now = text_of(attempt.error_now);
    row->artefacts = "[]";
    auto transaction = core_.store.transaction();
    core_.store.update_job(*row);
    if (old_film != row->film) purges_.note_removal(old_film);
    transaction.commit();
    if (old_film != row->film) purges_.remove_film(old_film);
}

}  // namespace photond
