#include "server/store/store.h"

#include <algorithm>
#include <charconv>
#include <functional>
#include <iterator>

#include "protocol/error.h"
#include "server/store/schema.h"

namespace photond {

namespace {

/// Every column of a job but seq, in the order of read_job() and bind_job().
constexpr const char* kJobColumns[] = {"state",
                                       "priority",
                                       "device",
                                       "method",
                                       "scene",
                                       "request",
                                       "created_ms",
                                       "started_ms",
                                       "finished_ms",
                                       "attempt",
                                       "crashes",
                                       "losses",
                                       "cancel_requested",
                                       "purge_requested",
                                       "passes_done",
                                       "progress",
                                       "seconds",
                                       "film",
                                       "pixel_hash",
                                       "statistics",
                                       "failure",
                                       "attempts",
                                       "artefacts",
                                       "role",
                                       "content",
                                       "reference_job",
                                       "comparison",
                                       "curve",
                                       "error_now",
                                       "second_reference_job"};
constexpr int kJobColumnCount = static_cast<int>(std::size(kJobColumns));

std::string joined(const std::function<std::string(int column)>& text) {
    std::string list;
    for (int i = 0; i < kJobColumnCount; ++i) list += (i ? ", " : "") + text(i);
    return list;
}

const std::string& select_jobs() {
    static const std::string kSelect =
        "SELECT seq, " + joined([](int i) { return std::string(kJobColumns[i]); }) + " FROM jobs";
    return kSelect;
}

/// From their two columns.
std::vector<int64_t> reference_jobs_of(const Statement& row, int first, int second) {
    std::vector<int64_t> jobs;
    for (const int column : {first, second})
        if (const auto seq = row.optional_integer(column)) jobs.push_back(*seq);
    return jobs;
}

std::optional<int64_t> reference_job_at(const JobRow& job, size_t place) {
    return place < job.reference_jobs.size() ? std::optional(job.reference_jobs[place]) : std::nullopt;
}

/// Reads a row of select_jobs().
JobRow read_job(const Statement& row) {
    JobRow job;
    job.seq = row.integer(0);
    job.state = static_cast<JobState>(row.integer(1));
    job.priority = static_cast<int>(row.integer(2));
    job.device = row.text(3);
    job.method = row.text(4);
    job.scene = row.text(5);
    job.request = row.text(6);
    job.created_ms = row.integer(7);
    job.started_ms = row.optional_integer(8);
    job.finished_ms = row.optional_integer(9);
    job.attempt = row.integer(10);
    job.crashes = static_cast<int>(row.integer(11));
    job.losses = static_cast<int>(row.integer(12));
    job.cancel_requested = row.integer(13) != 0;
    job.purge_requested = row.integer(14) != 0;
    job.passes_done = row.integer(15);
    job.progress = row.real(16);
    job.seconds = row.real(17);
    job.film = row.text(18);
    job.pixel_hash = row.text(19);
    job.statistics = row.text(20);
    job.failure = row.text(21);
    job.attempts = row.text(22);
    job.artefacts = row.text(23);
    job.role = static_cast<JobRole>(row.integer(24));
    job.content = row.text(25);
    job.reference_jobs = reference_jobs_of(row, 26, 30);
    job.comparison = row.optional_integer(27);
    job.curve = row.text(28);
    job.error_now = row.text(29);
    return job;
}

std::vector<JobRow> read_jobs(Statement& statement) {
    std::vector<JobRow> jobs;
    while (statement.step()) jobs.push_back(read_job(statement));
    return jobs;
}

std::optional<JobStanding> read_standing(Statement& read) {
    if (!read.step()) return std::nullopt;
    return JobStanding{read.integer(0), static_cast<JobState>(read.integer(1)), static_cast<JobRole>(read.integer(2)),
                       static_cast<int>(read.integer(3)), read.integer(4) != 0};
}

/// Binds the columns of kJobColumns to parameters 1, 2, ...
void bind_job(Statement& statement, const JobRow& job) {
    statement.bind(1, static_cast<int64_t>(job.state)).bind(2, static_cast<int64_t>(job.priority));
    statement.bind(3, job.device).bind(4, job.method).bind(5, job.scene).bind(6, job.request);
    statement.bind(7, job.created_ms).bind(8, job.started_ms).bind(9, job.finished_ms).bind(10, job.attempt);
    statement.bind(11, static_cast<int64_t>(job.crashes)).bind(12, static_cast<int64_t>(job.losses));
    statement.bind(13, static_cast<int64_t>(job.cancel_requested));
    statement.bind(14, static_cast<int64_t>(job.purge_requested));
    statement.bind(15, job.passes_done).bind(16, job.progress).bind(17, job.seconds);
    statement.bind(18, job.film).bind(19, job.pixel_hash).bind(20, job.statistics).bind(21, job.failure);
    statement.bind(22, job.attempts).bind(23, job.artefacts).bind(24, static_cast<int64_t>(job.role));
    statement.bind(25, job.content).bind(26, reference_job_at(job, 0)).bind(27, job.comparison);
    statement.bind(28, job.curve).bind(29, job.error_now).bind(30, reference_job_at(job, 1));
}

SceneRow read_scene(const Statement& row) {
    return {row.integer(0), row.text(1), row.text(2), row.text(3), row.text(4), row.integer(5)};
}

std::vector<std::string> read_texts(Statement& statement) {
    std::vector<std::string> texts;
    while (statement.step()) texts.push_back(statement.text(0));
    return texts;
}

}  // namespace

std::optional<JobState> job_state_named(std::string_view name) {
    for (size_t i = 0; i < std::size(kJobStates); ++i)
        if (kJobStates[i] == name) return static_cast<JobState>(i);
    return std::nullopt;
}

std::optional<JobRole> job_role_named(std::string_view name) {
    for (size_t i = 0; i < std::size(kJobRoles); ++i)
        if (kJobRoles[i] == name) return static_cast<JobRole>(i);
    return std::nullopt;
}

namespace {

constexpr char letter_of(GroupKind kind) { return kind == GroupKind::Sequence ? 'S' : 'C'; }

/// The number behind one letter: "J17"; 0 for anything else.
int64_t numbered_id(char letter, std::string_view id) {
    int64_t seq = 0;
    if (id.size() < 2 || id.size() > 19 || id[0] != letter || id[1] == '0') return 0;
    const auto [end, error] = std::from_chars(id.data() + 1, id.data() + id.size(), seq);
    return error == std::errc() && end == id.data() + id.size() && seq > 0 ? seq : 0;
}

}  // namespace

std::string job_id(int64_t seq) { return "J" + std::to_string(seq); }
int64_t job_seq(std::string_view id) { return numbered_id('J', id); }
std::string group_id(GroupKind kind, int64_t seq) { return letter_of(kind) + std::to_string(seq); }
int64_t group_seq(GroupKind kind, std::string_view id) { return numbered_id(letter_of(kind), id); }
std::string comparison_id(int64_t seq) { return group_id(GroupKind::Comparison, seq); }

Store::Store(const std::filesystem::path& file, Use use)
    : database_(use == Use::Read ? Database(file, kSchemaVersion) : Database(file, kMigrations, kSchemaVersion)) {
    if (use == Use::Read && is_new()) throw Error(ErrorCode::Internal, "the store " + file.string() + " is empty");
    Statement read = database_.prepare("SELECT value FROM meta WHERE key = 'store_id'");
    if (read.step()) id_ = read.text(0);
}

void Store::insert_job(JobRow& job) {
    static const std::string kInsert = "INSERT INTO jobs (" +
                                       joined([](int i) { return std::string(kJobColumns[i]); }) + ") VALUES (" +
                                       joined([](int i) { return "?" + std::to_string(i + 1); }) + ")";
    ++jobs_version_;
    Statement insert = database_.prepare(kInsert);
    bind_job(insert, job);
    insert.run();
    job.seq = database_.last_insert_id();
}

void Store::update_job(const JobRow& job) {
    static const std::string kUpdate = "UPDATE jobs SET " +
                                       joined([](int i) { return kJobColumns[i] + (" = ?" + std::to_string(i + 1)); }) +
                                       " WHERE seq = ?" + std::to_string(kJobColumnCount + 1);
    ++jobs_version_;
    Statement update = database_.prepare(kUpdate);
    bind_job(update, job);
    update.bind(kJobColumnCount + 1, job.seq).run();
}

void Store::delete_job(int64_t seq) {
    ++jobs_version_;
    database_.prepare("DELETE FROM events WHERE job = ?1").bind(1, seq).run();
    database_.prepare("DELETE FROM jobs WHERE seq = ?1").bind(1, seq).run();
}

std::optional<JobRow> Store::job(int64_t seq) {
    Statement read = database_.prepare(select_jobs() + " WHERE seq = ?1");
    read.bind(1, seq);
    if (!read.step()) return std::nullopt;
    return read_job(read);
}

std::vector<JobRow> Store::running_jobs() {
    Statement read = database_.prepare(select_jobs() + " WHERE state = 1 ORDER BY seq");
    return read_jobs(read);
}

std::vector<JobRow> Store::jobs_to_purge() {
    Statement read = database_.prepare(select_jobs() + " WHERE purge_requested = 1 AND state >= 2");
    return read_jobs(read);
}

std::vector<QueuedJob> Store::queued_jobs() {
    Statement read = database_.prepare(
        "SELECT seq, priority, device, (SELECT min(r.seq) FROM jobs r WHERE r.seq IN (j.reference_job, "
        "j.second_reference_job) AND r.state < 2) FROM jobs j WHERE state = 0");
    std::vector<QueuedJob> jobs;
    while (read.step())
        jobs.push_back({read.integer(0), static_cast<int>(read.integer(1)), read.text(2), read.optional_integer(3)});
    return jobs;
}

std::optional<JobStanding> Store::standing(int64_t seq) {
    Statement read = database_.prepare("SELECT seq, state, role, priority, cancel_requested FROM jobs WHERE seq = ?1");
    read.bind(1, seq);
    return read_standing(read);
}

std::optional<JobStanding> Store::reference_of_content(const std::string& content) {
    Statement read = database_.prepare(
        // That a content is not empty is said for the index of those that are not.
        "SELECT seq, state, role, priority, cancel_requested FROM jobs WHERE content = ?1 AND content <> '' "
        "AND state <= 2 ORDER BY seq DESC LIMIT 1");
    read.bind(1, content);
    return read_standing(read);
}

std::vector<JobRow> Store::unfinished_jobs_measured_against(int64_t seq) {
    Statement read = database_.prepare(
        // By two indexes; of an OR SQLite would rather look through all jobs that are not over.
        select_jobs() +
        " WHERE seq IN (SELECT seq FROM jobs WHERE reference_job = ?1 AND state IN (0, 1) "
        "UNION SELECT seq FROM jobs WHERE second_reference_job = ?1 AND state IN (0, 1)) ORDER BY seq");
    read.bind(1, seq);
    return read_jobs(read);
}

std::vector<JobRow> Store::queued_jobs_of_scene(const std::string& scene) {
    Statement read = database_.prepare(select_jobs() + " WHERE scene = ?1 AND state = 0 ORDER BY seq");
    read.bind(1, scene);
    return read_jobs(read);
}

int64_t Store::unfinished_jobs_of_scene(const std::string& scene) {
    Statement read = database_.prepare("SELECT count(*) FROM jobs WHERE scene = ?1 AND state IN (0, 1)");
    read.bind(1, scene);
    return read.step() ? read.integer(0) : 0;
}

std::vector<FilmRow> Store::films() {
    Statement read = database_.prepare("SELECT seq, film, artefacts FROM jobs WHERE film <> ''");
    std::vector<FilmRow> rows;
    while (read.step()) rows.push_back({read.integer(0), read.text(1), read.text(2)});
    return rows;
}

std::vector<JobRow> Store::latest_succeeded(const std::string& method, uint32_t limit) {
    Statement read = database_.prepare(select_jobs() + " WHERE method = ?1 AND state = 2 ORDER BY seq DESC LIMIT ?2");
    read.bind(1, method).bind(2, static_cast<int64_t>(limit));
    return read_jobs(read);
}

void Store::append_log(int64_t seq, int64_t at_ms, const std::string& line) {
    database_.prepare("INSERT INTO job_log (job, at_ms, line) VALUES (?1, ?2, ?3)")
        .bind(1, seq)
        .bind(2, at_ms)
        .bind(3, line)
        .run();
}

std::vector<std::pair<int64_t, std::string>> Store::log(int64_t seq) {
    Statement read = database_.prepare("SELECT at_ms, line FROM job_log WHERE job = ?1 ORDER BY id");
    read.bind(1, seq);
    std::vector<std::pair<int64_t, std::string>> lines;
    while (read.step()) lines.emplace_back(read.integer(0), read.text(1));
    return lines;
}

std::optional<Store::KeyRow> Store::key(const std::string& key) {
    Statement read = database_.prepare("SELECT body_sha256, job FROM keys WHERE key = ?1");
    read.bind(1, key);
    if (!read.step()) return std::nullopt;
    return KeyRow{read.text(0), read.integer(1)};
}

void Store::insert_key(const std::string& key, const std::string& body_sha256, int64_t job, int64_t at_ms) {
    database_.prepare("INSERT INTO keys (key, body_sha256, at_ms, job) VALUES (?1, ?2, ?3, ?4)")
        .bind(1, key)
        .bind(2, body_sha256)
        .bind(3, at_ms)
        .bind(4, job)
        .run();
}

void Store::insert_scene(SceneRow& scene) {
    database_.prepare("INSERT INTO scenes (id, name, file, summary, created_ms) VALUES (?1, ?2, ?3, ?4, ?5)")
        .bind(1, scene.id)
        .bind(2, scene.name)
        .bind(3, scene.file)
        .bind(4, scene.summary)
        .bind(5, scene.created_ms)
        .run();
    scene.seq = database_.last_insert_id();
}

void Store::set_scene_summary(const std::string& id, const std::string& summary) {
    database_.prepare("UPDATE scenes SET summary = ?2 WHERE id = ?1").bind(1, id).bind(2, summary).run();
}

void Store::delete_scene(const std::string& id) {
    database_.prepare("DELETE FROM scenes WHERE id = ?1").bind(1, id).run();
}

std::optional<SceneRow> Store::scene(const std::string& id) {
    Statement read = database_.prepare("SELECT seq, id, name, file, summary, created_ms FROM scenes WHERE id = ?1");
    read.bind(1, id);
    if (!read.step()) return std::nullopt;
    return read_scene(read);
}

std::optional<SceneRow> Store::scene_named(const std::string& name) {
    Statement read = database_.prepare(
        "SELECT seq, id, name, file, summary, created_ms FROM scenes WHERE name = ?1 ORDER BY seq DESC LIMIT 1");
    read.bind(1, name);
    if (!read.step()) return std::nullopt;
    return read_scene(read);
}

std::vector<SceneRow> Store::scenes(int64_t before, uint32_t limit) {
    Statement read = database_.prepare(
        "SELECT seq, id, name, file, summary, created_ms FROM scenes WHERE seq < ?1 ORDER BY seq DESC LIMIT ?2");
    read.bind(1, before).bind(2, static_cast<int64_t>(limit));
    std::vector<SceneRow> scenes;
    while (read.step()) scenes.push_back(read_scene(read));
    return scenes;
}

std::vector<std::string> Store::scene_ids() {
    Statement read = database_.prepare("SELECT id FROM scenes");
    return read_texts(read);
}

void Store::insert_image(const ImageRow& image) {
    database_
        .prepare(
            "INSERT INTO images (id, media_type, file, width, height, channels, bytes, created_ms, layers) VALUES (?1, "
            "?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)")
        .bind(1, image.id)
        .bind(2, image.media_type)
        .bind(3, image.file)
        .bind(4, image.width)
        .bind(5, image.height)
        .bind(6, image.channels)
        .bind(7, image.bytes)
        .bind(8, image.created_ms)
        .bind(9, image.layers)
        .run();
}

void Store::delete_image(const std::string& id) {
    database_.prepare("DELETE FROM images WHERE id = ?1").bind(1, id).run();
}

std::optional<ImageRow> Store::image(const std::string& id) {
    Statement read = database_.prepare(
        "SELECT id, media_type, file, width, height, channels, bytes, created_ms, layers FROM images WHERE id = ?1");
    read.bind(1, id);
    if (!read.step()) return std::nullopt;
    return ImageRow{read.text(0),    read.text(1),    read.text(2),    read.integer(3), read.integer(4),
                    read.integer(5), read.integer(6), read.integer(7), read.text(8)};
}

void Store::set_image_layers(const std::string& id, const std::string& layers) {
    database_.prepare("UPDATE images SET layers = ?2 WHERE id = ?1").bind(1, id).bind(2, layers).run();
}

std::vector<std::pair<std::string, std::string>> Store::image_files() {
    Statement read = database_.prepare("SELECT id, file FROM images");
    std::vector<std::pair<std::string, std::string>> rows;
    while (read.step()) rows.emplace_back(read.text(0), read.text(1));
    return rows;
}

void Store::insert_event(const Event& event, int64_t job) {
    database_.prepare("INSERT INTO events (id, job, type, data) VALUES (?1, ?2, ?3, ?4)")
        .bind(1, static_cast<int64_t>(event.id))
        .bind(2, job)
        .bind(3, event.type)
        .bind(4, event.data)
        .run();
}

std::vector<Event> Store::events(uint64_t after_id, uint64_t before_id, int64_t job, size_t limit) {
    Statement read = database_.prepare(
        job ? "SELECT id, job, type, data FROM events WHERE id > ?1 AND id < ?2 AND job = ?4 ORDER BY id LIMIT ?3"
            : "SELECT id, job, type, data FROM events WHERE id > ?1 AND id < ?2 ORDER BY id LIMIT ?3");
    // Ids are SQLite's signed 64-bit integers; a client may ask beyond them.
    constexpr uint64_t kLast = INT64_MAX;
    read.bind(1, static_cast<int64_t>(std::min(after_id, kLast)));
    read.bind(2, static_cast<int64_t>(std::min(before_id, kLast)));
    read.bind(3, static_cast<int64_t>(limit));
    if (job) read.bind(4, job);
    std::vector<Event> events;
    while (read.step())
        events.push_back({static_cast<uint64_t>(read.integer(0)), read.text(2), job_id(read.integer(1)), read.text(3)});
    return events;
}

void Store::prune_events(size_t keep) {
    database_.prepare("DELETE FROM events WHERE id <= (SELECT id FROM events ORDER BY id DESC LIMIT 1 OFFSET ?1)")
        .bind(1, static_cast<int64_t>(keep))
        .run();
}

uint64_t Store::event_ids_until() {
    Statement read = database_.prepare("SELECT value FROM meta WHERE key = 'event_ids_until'");
    return read.step() ? static_cast<uint64_t>(read.integer(0)) : 1;
}

void Store::set_event_ids_until(uint64_t id) {
    database_.prepare("INSERT OR REPLACE INTO meta (key, value) VALUES ('event_ids_until', ?1)")
        .bind(1, static_cast<int64_t>(id))
        .run();
}

std::string Store::requests_are_of() {
    Statement read = database_.prepare("SELECT value FROM meta WHERE key = 'requests_are_of'");
    return read.step() ? read.text(0) : "";
}

void Store::set_requests_are_of(const std::string& text) {
    database_.prepare("INSERT OR REPLACE INTO meta (key, value) VALUES ('requests_are_of', ?1)").bind(1, text).run();
}

void Store::change_requests(const std::function<bool(KeptRequest&)>& change) {
    std::vector<std::pair<int64_t, KeptRequest>> changed;
    {
        Statement read = database_.prepare("SELECT seq, request, scene, content FROM jobs");
        while (read.step())
            if (KeptRequest kept{read.text(1), read.text(2), read.text(3)}; change(kept))
                changed.emplace_back(read.integer(0), std::move(kept));
    }
    if (!changed.empty()) ++jobs_version_;
    for (const auto& [seq, kept] : changed)
        database_.prepare("UPDATE jobs SET request = ?2, content = ?3 WHERE seq = ?1")
            .bind(1, seq)
            .bind(2, kept.request)
            .bind(3, kept.content)
            .run();
    changed.clear();
    {
        Statement read = database_.prepare("SELECT seq, request, scene FROM comparisons");
        while (read.step())
            if (KeptRequest kept{read.text(1), read.text(2)}; change(kept))
                changed.emplace_back(read.integer(0), std::move(kept));
    }
    for (const auto& [seq, kept] : changed)
        database_.prepare("UPDATE comparisons SET request = ?2 WHERE seq = ?1")
            .bind(1, seq)
            .bind(2, kept.request)
            .run();
}

void Store::note_unnamed_file(const std::string& path) {
    for (const std::string& gone : std::exchange(gone_files_, {})) forget_unnamed_file(gone);
    database_.prepare("INSERT OR IGNORE INTO unnamed_files (path) VALUES (?1)").bind(1, path).run();
}

void Store::forget_unnamed_file(const std::string& path) {
    database_.prepare("DELETE FROM unnamed_files WHERE path = ?1").bind(1, path).run();
}

std::vector<std::string> Store::unnamed_files() {
    if (id_.empty()) return {};  // an older one, opened to be read
    Statement read = database_.prepare("SELECT path FROM unnamed_files");
    return read_texts(read);
}

}  // namespace photond
