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

void AttemptProgress::publish_untold(RunningAttempt& attempt) {
    publish_progress(attempt);
    publish_curve(attempt);
}

void AttemptProgress::publish_progress(RunningAttempt& attempt) {
    const auto now = SteadyClock::now();
    if (!attempt.progress_untold || now - attempt.last_event < kProgressInterval) return;
    attempt.last_event = now;
    attempt.progress_untold = false;
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

void AttemptProgress::progress(RunningAttempt& attempt, const ProgressMessage& told) {
    attempt.passes_done = told.passes_done;
    attempt.progress = std::clamp(told.progress, 0.0, 1.0);
    attempt.seconds = told.seconds;
    attempt.error_now = part_json(told.error_now);
    attempt.progress_untold = true;
    publish_progress(attempt);
}

void AttemptProgress::curve(RunningAttempt& attempt, const CurveMessage& told) {
    if (attempt.curve.size() + told.points.size() > kMaxCurvePoints) return;
    // A job that goes on from a film sends that film's points too; they were told by the attempt before.
    json known = json::array();
    if (!std::exchange(attempt.curve_begun, true)) known.swap(attempt.curve);
    for (const json& point : told.points) {
        if (std::find(known.begin(), known.end(), point) == known.end()) attempt.unpublished.push_back(point);
        attempt.curve.push_back(point);
    }
    attempt.error_now = part_json(told.error_now);
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

void AttemptProgress::film_saved(RunningAttempt& attempt, const FilmSavedMessage& told) {
    const fs::path& path = told.path;
    if (path == core_.files.films / attempt.film) return records_.keep_film(attempt, told.passes_done);
    const std::string mine = attempt.film + ".s";
    if (path.parent_path() != core_.files.films || !path.filename().string().starts_with(mine)) return;
    auto snapshot = std::make_shared<Snapshot>();
    snapshot->path = path;
    snapshot->passes_done = told.passes_done;
    snapshot->saved = SteadyClock::now();
    attempt.snapshot = std::move(snapshot);
    core_.attempt_changed.notify_all();
}

}  // namespace photond
