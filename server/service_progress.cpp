// What is heard of a running attempt and told of its job: progress, curve, films saved on the way, events.

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "protocol/worker_messages.h"
#include "server/clock_text.h"
#include "server/row_text.h"
#include "server/service_impl.h"

namespace photond {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr size_t kMaxCurvePoints = 10'000;  // a worker gone astray; a curve has some sixty

std::string curve_data(int64_t seq, const json& points, const std::string& error_now) {
    return json{{"id", job_id(seq)}, {"curve", points}, {"error_now", parsed_or_null(error_now)}}.dump(
        -1, ' ', false, json::error_handler_t::replace);
}

}  // namespace

std::string text_of(const json& value) {
    return value.empty() ? "" : value.dump(-1, ' ', false, json::error_handler_t::replace);
}

json object_or_null(const json& message, const char* member) {
    const json value = message.value(member, json());
    return value.is_object() ? value : json();
}

std::string Service::Impl::state_data(const JobRow& row) {
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

void Service::Impl::put_event(Outbox& outbox, const char* type, int64_t job, std::string data) {
    outbox.events.push_back({events.next_id() + outbox.events.size(), type, job_id(job), std::move(data)});
    if (events.next_id() + outbox.events.size() >= outbox.ids_until)
        outbox.ids_until = reserve_event_ids(outbox.events.size());
    store.insert_event(outbox.events.back(), job);
}

void Service::Impl::tell(Outbox outbox) {
    event_ids_until = std::max(event_ids_until, outbox.ids_until);
    for (Event& event : outbox.events) events.publish(std::move(event));
}

void Service::Impl::commit_state(JobRow& row, const std::string& log_line, const std::function<void()>& more,
                                 const json& new_points) {
    Outbox outbox;
    auto transaction = store.transaction();
    store.update_job(row);
    if (more) more();
    store.append_log(row.seq, now_ms(), log_line);
    if (!new_points.empty()) put_event(outbox, "curve", row.seq, curve_data(row.seq, new_points, row.error_now));
    put_event(outbox, "state", row.seq, state_data(row));
    transaction.commit();
    tell(std::move(outbox));
}

void Service::Impl::publish_progress(const RunningAttempt& attempt) {
    if (events.next_id() >= event_ids_until) {
        auto transaction = store.transaction();
        const uint64_t reserved = reserve_event_ids(1);
        transaction.commit();
        event_ids_until = reserved;
    }
    const json data = {{"id", job_id(attempt.seq)},
                       {"progress", attempt.progress},
                       {"passes_done", attempt.passes_done},
                       {"seconds", attempt.seconds},
                       {"error_now", attempt.error_now}};
    events.publish({events.next_id(), "progress", job_id(attempt.seq), data.dump()});
}

void Service::Impl::progress(Slot& slot, const json& message) {
    RunningAttempt& attempt = *slot.running;
    attempt.passes_done = message.value("passes_done", attempt.passes_done);
    attempt.progress = std::clamp(message.value("progress", attempt.progress), 0.0, 1.0);
    attempt.seconds = message.value("seconds", attempt.seconds);
    if (message.contains("error_now")) attempt.error_now = object_or_null(message, "error_now");
    const auto now = SteadyClock::now();
    if (now - attempt.last_event < kProgressInterval) return;  // the next one says it all
    attempt.last_event = now;
    publish_progress(attempt);
}

void Service::Impl::curve(Slot& slot, const json& message) {
    RunningAttempt& attempt = *slot.running;
    const json points = message.value("points", json::array());
    if (!points.is_array() || attempt.curve.size() + points.size() > kMaxCurvePoints) return;
    // A job that goes on from a film sends that film's points too; they were told by the attempt before.
    if (!attempt.curve_begun) {
        const json told = std::exchange(attempt.curve, json::array());
        attempt.curve_begun = true;
        for (const json& point : points)
            if (std::find(told.begin(), told.end(), point) == told.end()) attempt.unpublished.push_back(point);
    } else {
        attempt.unpublished.insert(attempt.unpublished.end(), points.begin(), points.end());
    }
    attempt.curve.insert(attempt.curve.end(), points.begin(), points.end());
    if (message.contains("error_now")) attempt.error_now = object_or_null(message, "error_now");
    publish_curve(attempt);
}

void Service::Impl::publish_curve(RunningAttempt& attempt) {
    const auto now = SteadyClock::now();
    if (attempt.unpublished.empty() || now - attempt.last_curve_event < kProgressInterval) return;
    attempt.last_curve_event = now;
    Outbox outbox;
    try {
        auto transaction = store.transaction();
        put_event(outbox, "curve", attempt.seq,
                  curve_data(attempt.seq, attempt.unpublished, text_of(attempt.error_now)));
        transaction.commit();
    } catch (const std::exception& error) {  // told later, with the points to come
        spdlog::error("job {}: its curve cannot be told yet: {}", job_id(attempt.seq), error.what());
        return;
    }
    attempt.unpublished = json::array();
    tell(std::move(outbox));
}

void Service::Impl::film_saved(Slot& slot, const json& message) {
    RunningAttempt& attempt = *slot.running;
    const fs::path path = message.value("path", "");
    if (path == files.films / attempt.film) return keep_film(attempt, message.value("passes_done", int64_t{0}));
    const std::string mine = attempt.film + ".s";
    if (path.parent_path() != files.films || !path.filename().string().starts_with(mine)) return;
    auto snapshot = std::make_shared<Snapshot>();
    snapshot->path = path;
    snapshot->passes_done = message.value("passes_done", int64_t{0});
    snapshot->saved = SteadyClock::now();
    attempt.snapshot = std::move(snapshot);
    attempt_changed.notify_all();
}

void Service::Impl::keep_film(const RunningAttempt& attempt, int64_t passes_done) {
    auto row = store.job(attempt.seq);
    if (!row || row->state != JobState::Running || row->attempt != attempt.attempt) return;
    const std::string old_film = std::exchange(row->film, attempt.film);
    row->passes_done = passes_done;
    row->seconds = attempt.seconds;
    row->progress = attempt.progress;
    row->curve = text_of(attempt.curve);
    row->error_now = text_of(attempt.error_now);
    auto transaction = store.transaction();
    store.update_job(*row);
    transaction.commit();
    if (old_film != row->film) remove_film(old_film);
}

}  // namespace photond
