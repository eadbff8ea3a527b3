#include "server/service/attempt_progress.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "server/row_text.h"

namespace photond {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr size_t kMaxCurvePoints = 10'000;  // a worker gone astray; a curve has some sixty

}  // namespace

void AttemptProgress::publish_progress(const RunningAttempt& attempt) {
    if (core_.events.next_id() >= core_.event_ids_until) {
        auto transaction = core_.store.transaction();
        const uint64_t reserved = core_.reserve_event_ids(1);
        transaction.commit();
        core_.event_ids_until = reserved;
    }
    const json data = {{"id", job_id(attempt.seq)},
                       {"progress", attempt.progress},
                       {"passes_done", attempt.passes_done},
                       {"seconds", attempt.seconds},
                       {"error_now", attempt.error_now}};
    core_.events.publish({core_.events.next_id(), "progress", job_id(attempt.seq), data.dump()});
}

void AttemptProgress::progress(RunningAttempt& attempt, const json& message) {
    attempt.passes_done = message.value("passes_done", attempt.passes_done);
    attempt.progress = std::clamp(message.value("progress", attempt.progress), 0.0, 1.0);
    attempt.seconds = message.value("seconds", attempt.seconds);
    if (message.contains("error_now")) attempt.error_now = object_or_null(message, "error_now");
    const auto now = SteadyClock::now();
    if (now - attempt.last_event < kProgressInterval) return;  // the next one says it all
    attempt.last_event = now;
    publish_progress(attempt);
}

void AttemptProgress::curve(RunningAttempt& attempt, const json& message) {
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

void AttemptProgress::publish_curve(RunningAttempt& attempt) {
    const auto now = SteadyClock::now();
    if (attempt.unpublished.empty() || now - attempt.last_curve_event < kProgressInterval) return;
    attempt.last_curve_event = now;
    Outbox outbox;
    try {
        auto transaction = core_.store.transaction();
        core_.put_event(outbox, "curve", attempt.seq,
                        curve_data(attempt.seq, attempt.unpublished, text_of(attempt.error_now)));
        transaction.commit();
    } catch (const std::exception& error) {  // told later, with the points to come
        spdlog::error("job {}: its curve cannot be told yet: {}", job_id(attempt.seq), error.what());
        return;
    }
    attempt.unpublished = json::array();
    core_.tell(std::move(outbox));
}

void AttemptProgress::film_saved(RunningAttempt& attempt, const json& message) {
    const fs::path path = message.value("path", "");
    if (path == core_.files.films / attempt.film)
        return records_.keep_film(attempt, message.value("passes_done", int64_t{0}));
    const std::string mine = attempt.film + ".s";
    if (path.parent_path() != core_.files.films || !path.filename().string().starts_with(mine)) return;
    auto snapshot = std::make_shared<Snapshot>();
    snapshot->path = path;
    snapshot->passes_done = message.value("passes_done", int64_t{0});
    snapshot->saved = SteadyClock::now();
    attempt.snapshot = std::move(snapshot);
    core_.attempt_changed.notify_all();
}

}  // namespace photond
