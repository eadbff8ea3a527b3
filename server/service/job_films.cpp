#include "server/service/job_films.h"

#include <utility>

#include "server/asks_again.h"
#include "server/row_text.h"
#include "server/service/artefact_files.h"
#include "server/try_later.h"

namespace photond {

namespace fs = std::filesystem;

namespace {

constexpr auto kSnapshotPatience = std::chrono::seconds(5);    // for the disk to take the film; then 202
constexpr auto kMoment = std::chrono::milliseconds(300);       // the same where the client asks again
constexpr auto kSnapshotAge = std::chrono::milliseconds(500);  // a film younger than this is "so far"

}  // namespace

fs::path require_kept(const fs::path& file, const std::string& job) {
    std::error_code error;
    if (fs::is_regular_file(fs::symlink_status(file, error))) return file;
    throw Error(ErrorCode::ResultLost, "job " + job + " has lost " + file.filename().string() +
                                           ": it is not in the data folder's " +
                                           file.parent_path().filename().string() + "/ any more");
}

void JobFilms::pin(FilmSource& film) {
    auto held = std::make_shared<Snapshot>();
    // What cannot be read of it is said with its own name.
    const fs::path name = core_.files.fresh_spool_path().string() + "-" + film.path.filename().string();
    link_or_copy(film.path, name);
    held->path = film.path = name;
    film.pin = std::move(held);
}

FilmSource JobFilms::film_source(const std::string& id) {
    std::unique_lock lock(core_.mutex);
    const bool asks_again = client_asks_again();
    const auto give_up = SteadyClock::now() + (asks_again ? kMoment : kSnapshotPatience);
    bool late = false;
    std::string asked_for;  // the snapshot under way for us
    while (true) {
        const JobRow row = objects_.require_job(id);
        const std::string prefix = "job/" + std::to_string(row.seq) + "/";
        if (row.state != JobState::Running) {
            if (!row.film.empty())
                return {false,
                        require_kept(core_.files.films / row.film, id),
                        prefix + row.film,
                        prefix + row.film,
                        parsed_or_null(row.statistics),
                        parsed_or_null(row.request),
                        nullptr};
            if (row.state == JobState::Queued) return {.pending = true};
            throw Error(ErrorCode::NotFound, "job " + id + " " + std::string(job_state_name(row.state)) +
                                                 " before its first pass was done: it has no film");
        }
        const RunningAttempt* attempt = attempts_.running_attempt(row.seq);
        if (!attempt || attempt->passes_done == 0) return {.pending = true};
        const auto& snapshot = attempt->snapshot;
        const bool is_newest = snapshot && snapshot->passes_done >= attempt->passes_done;
        if (snapshot && (is_newest || snapshot->path == asked_for || (late && asks_again) ||
                         SteadyClock::now() - snapshot->saved < kSnapshotAge))
            return {false,
                    snapshot->path,
                    prefix + snapshot->path.filename().string(),
                    prefix + "newest",
                    nullptr,
                    parsed_or_null(row.request),
                    snapshot};
        if (asked_for.empty()) asked_for = attempts_.ask_for_snapshot(row.seq).string();
        if (late && asks_again) throw TryLater("the film so far is being saved", 1, true);
        if (late || core_.stopping) return {.pending = true};
        late = core_.attempt_changed.wait_until(lock, give_up) == std::cv_status::timeout;
    }
}

}  // namespace photond
