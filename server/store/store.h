#pragma once
// What the daemon must not forget: jobs, scenes, images, idempotency keys, events. Typed rows over one SQLite database.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/events.h"
#include "server/store/database.h"

namespace photond {

enum class JobState : uint8_t { Queued, Running, Succeeded, Failed, Cancelled };
inline constexpr std::string_view kJobStates[] = {"queued", "running", "succeeded", "failed", "cancelled"};
constexpr std::string_view job_state_name(JobState state) { return kJobStates[static_cast<size_t>(state)]; }
std::optional<JobState> job_state_named(std::string_view name);
constexpr bool is_over(JobState state) { return state >= JobState::Succeeded; }

/// Why a job is there.
enum class JobRole : uint8_t {
    Render,     // somebody asked for it
    Reference,  // others are measured against it; made once for each content
    Merged,     // joined from the films of others, never rendered
    Frame,      // of a sequence that somebody asked for
};
inline constexpr std::string_view kJobRoles[] = {"render", "reference", "merged", "frame"};
constexpr std::string_view job_role_name(JobRole role) { return kJobRoles[static_cast<size_t>(role)]; }
std::optional<JobRole> job_role_named(std::string_view name);

/// A job as it is kept. Times are milliseconds since 1970 UTC; JSON members are texts.
struct JobRow {
    int64_t seq = 0;  // rising, never used twice; the id is "J" and this
    JobState state = JobState::Queued;
    int priority = 0;
    std::string device, method, scene;
    std::string request;  // JSON, every default filled in
    int64_t created_ms = 0;
    std::optional<int64_t> started_ms, finished_ms;
    int64_t attempt = 0;  // fencing token: attempts begun so far
    int crashes = 0;      // attempts ended by the worker's own signal, since the last retry or saved progress
    int losses = 0;       // attempts lost through no fault of the job, since the last retry or saved progress
    bool cancel_requested = false;
    bool purge_requested = false;
    int64_t passes_done = 0;
    double progress = 0;
    double seconds = 0;
    std::string film;  // file name in the films folder; empty: none
    std::string pixel_hash;
    std::string statistics;        // JSON or empty
    std::string failure;           // JSON (problem) or empty
    std::string attempts = "[]";   // JSON
    std::string artefacts = "[]";  // JSON: names of what the method left beside the film
    JobRole role = JobRole::Render;
    std::string content;  // of a reference: the hash of what it shows and how; else empty
    /// Seqs of the jobs it is measured against, one that was named or two films made for it; it waits for their ends.
    std::vector<int64_t> reference_jobs;
    std::optional<int64_t> comparison;  // seq of the comparison it belongs to, or as a frame of the sequence
    std::string curve;                  // JSON array of points; empty: none
    std::string error_now;              // JSON {"metric", "value"}; empty: none
};

/// Of a job what says whether others wait for it.
struct JobStanding {
    int64_t seq = 0;
    JobState state = JobState::Queued;
    JobRole role = JobRole::Render;
    int priority = 0;
    bool cancel_requested = false;
};

/// What is asked for as many jobs at once.
enum class GroupKind : uint8_t { Comparison, Sequence };

/// A comparison, or a sequence of frames, is what was asked for and its jobs; its state and its tables follow from
/// those.
struct ComparisonRow {
    int64_t seq = 0;  // rising, never used twice by either; the id is "C" or "S" and this
    std::string scene;
    std::string request;  // JSON, every default filled in
    int64_t created_ms = 0;
    bool purge_requested = false;
    GroupKind kind = GroupKind::Comparison;
};
struct ComparisonJob {
    int64_t job = 0;
    std::string label;
    std::string parameters;  // JSON object: those the sweep gave, by name; of a frame its "time"
    uint64_t seed = 1;
    std::optional<int64_t> repeat_of = {};  // of a repeat: the job that was planned in its place

    int64_t planned() const { return repeat_of.value_or(job); }
};

/// Bias and noise of the films of a row, apart.
struct RowBias {
    std::string films, layer;  // what the films are called, in one hash
    std::string errors;        // JSON {metric: {"squared_bias", "low", "high", ...}}
};

/// What the state of a comparison follows from, for one of its jobs.
struct JobProgress {
    int64_t seq = 0;
    JobState state = JobState::Queued;
    std::string device;
    double progress = 0, seconds = 0;
    std::optional<int64_t> started_ms, finished_ms;
    std::vector<int64_t> reference_jobs = {};  // as in JobRow
    std::optional<int64_t> repeat_of = {};     // as in ComparisonJob

    int64_t planned() const { return repeat_of.value_or(seq); }
};

/// Of all jobs of a comparison or sequence that are in a state.
struct StateCount {
    JobState state = JobState::Queued;
    int64_t jobs = 0;
    double progress = 0;  // all of theirs together
    std::optional<int64_t> first_started_ms, last_finished_ms;
};

/// What a sequence shows of a frame.
struct FrameRow {
    int64_t job = 0;
    std::string parameters;  // as in ComparisonJob
    uint64_t seed = 1;
    JobState state = JobState::Queued;
    double progress = 0, seconds = 0;
};

/// What is left to do with a job that goes.
struct RemovableJob {
    int64_t seq = 0;
    JobState state = JobState::Queued;
    std::string film;  // as in JobRow
};

/// Likewise of a job that others are measured against.
struct ReferenceProgress {
    JobProgress job;
    JobRole role = JobRole::Render;
    int64_t created_ms = 0;

    /// Whether it was made for the jobs of that one, and not there before.
    bool is_own(const ComparisonRow& comparison) const {
        return role == JobRole::Reference && created_ms >= comparison.created_ms;
    }
};

struct SceneRow {
    int64_t seq = 0;
    std::string id, name, file;  // file: relative to the scene's folder
    std::string summary;         // JSON, without id
    int64_t created_ms = 0;
};

struct ImageRow {
    std::string id, media_type, file;
    int64_t width = 0, height = 0, channels = 0, bytes = 0, created_ms = 0;
    std::string layers;  // JSON: [{"name", "channels"}..]; empty where it came before they were noted
};

/// What a list shows of a job. None of it is long.
struct JobSummary {
    int64_t seq = 0;
    JobState state = JobState::Queued;
    JobRole role = JobRole::Render;
    std::string device, method;
    std::string scene;   // as the request names it
    std::string labels;  // JSON object
    int priority = 0;
    std::optional<int64_t> comparison;
    int64_t created_ms = 0;
    std::optional<int64_t> started_ms, finished_ms;
    double progress = 0;
    int64_t passes_done = 0;
    double seconds = 0;
    std::string error_now;  // as in JobRow
    int64_t width = 0, height = 0;
    std::string failure;  // what went wrong, as text; empty: nothing
};

/// Newest: last submitted first; Queue: of waiting jobs as they will run; Ended: of those that are over, the last
/// first.
enum class JobOrder : uint8_t { Newest, Queue, Ended };

struct JobQuery {
    JobOrder order = JobOrder::Newest;
    std::vector<JobState> states;  // empty: any
    std::optional<JobRole> role;
    std::string label_key;
    std::optional<std::string> label_value;
    std::string scene, method, device;  // empty: any
    int64_t before = INT64_MAX;         // seq of the last row of the page before
    uint32_t offset = 0;                // rows to skip from there
    uint32_t limit = 100;
};

/// Of a job what it names in the films folder.
struct FilmRow {
    int64_t seq = 0;
    std::string film;
    std::string artefacts;  // JSON: names of what lies beside it
    bool operator==(const FilmRow&) const = default;
};

/// What a job or a comparison was asked for by, and what else follows from it.
struct KeptRequest {
    std::string request;       // JSON
    std::string scene;         // id
    std::string content = {};  // as in JobRow
};

struct QueuedJob {
    int64_t seq;
    int priority;
    std::string device;
    std::optional<int64_t> waits_for;  // a job it is measured against that is not over
};

/// Not thread-safe: the service's lock serialises. Every write is inside a transaction() of the caller.
class Store {
public:
    enum class Use : uint8_t { Serve, Read };  // Read: as it lies there, and nothing of it can be changed

    explicit Store(const std::filesystem::path& file, Use use = Use::Serve);

    /// A random number of 32 hexadecimal digits, given to it when it was made: its films carry it. Empty of an older
    /// one that is only read.
    const std::string& id() const { return id_; }
    /// There was no store before, or nothing in it.
    bool is_new() const { return database_.found_version() == 0; }
    Database& database() { return database_; }

    Database::Transaction transaction() { return Database::Transaction(database_); }

    // --- jobs
    // ---------------------------------------------------------------------------------------------------------
    /// Fills in seq.
    void insert_job(JobRow& job);
    void update_job(const JobRow& job);
    void delete_job(int64_t seq);
    std::optional<JobRow> job(int64_t seq);
    std::optional<JobSummary> job_summary(int64_t seq);
    std::optional<JobStanding> standing(int64_t seq);
    /// Numbers of a page's jobs, in its order; the jobs are read one by one, so that a long page need not be read under
    /// one lock. Not inside a transaction that changes jobs: what was read there would outlive its end.
    std::vector<int64_t> job_page(const JobQuery& query);
    /// How many there are in all, wherever the page begins. Likewise.
    int64_t count_jobs(const JobQuery& query);
    std::vector<JobRow> running_jobs();
    /// Over, and asked to be removed.
    std::vector<JobRow> jobs_to_purge();
    std::vector<QueuedJob> queued_jobs();
    /// The newest reference of that content that succeeded, runs or waits.
    std::optional<JobStanding> reference_of_content(const std::string& content);
    /// Jobs that are measured against that one and are not over.
    std::vector<JobRow> unfinished_jobs_measured_against(int64_t seq);
    std::vector<JobRow> queued_jobs_of_scene(const std::string& scene);
    int64_t unfinished_jobs_of_scene(const std::string& scene);
    /// Of every job that has a film.
    std::vector<FilmRow> films();
    /// The newest succeeded jobs of a method, at most `limit`; for estimates.
    std::vector<JobRow> latest_succeeded(const std::string& method, uint32_t limit);

    /// Shows it the request of every job and of every comparison; where it changes one it says so, and request and
    /// content are written.
    void change_requests(const std::function<bool(KeptRequest&)>& change);
    /// A text that stands for what the requests were last brought up to; empty: nothing.
    std::string requests_are_of();
    void set_requests_are_of(const std::string& text);

    void append_log(int64_t seq, int64_t at_ms, const std::string& line);
    std::vector<std::pair<int64_t, std::string>> log(int64_t seq);

    // --- idempotency
    // --------------------------------------------------------------------------------------------------
    struct KeyRow {
        std::string body_sha256;
        int64_t job;
    };
    std::optional<KeyRow> key(const std::string& key);
    void insert_key(const std::string& key, const std::string& body_sha256, int64_t job, int64_t at_ms);

    // --- comparisons
    // ------------------------------------------------------------------------------------------------------
    /// Fills in seq.
    void insert_comparison(ComparisonRow& comparison);
    void insert_comparison_job(int64_t comparison, int64_t place, const ComparisonJob& job);
    void update_comparison(const ComparisonRow& comparison);
    void delete_comparison(int64_t seq);
    std::optional<ComparisonRow> comparison(int64_t seq);
    /// Newest first.
    std::vector<ComparisonRow> comparisons(int64_t before, uint32_t limit, GroupKind kind = GroupKind::Comparison);
    /// In the order they were planned, repeats after them.
    std::vector<ComparisonJob> comparison_jobs(int64_t seq);
    /// Likewise; those jobs that are still there.
    std::vector<JobProgress> comparison_progress(int64_t seq);
    /// Of those jobs by state, each state once.
    std::vector<StateCount> count_states(int64_t comparison);
    /// Those that run, by what their rows say.
    std::vector<JobProgress> running_jobs_of(int64_t comparison);
    std::vector<FrameRow> frames(int64_t sequence);
    /// The job whose place is before that of this one.
    std::optional<int64_t> frame_before(int64_t sequence, int64_t job);
    std::vector<JobRow> unfinished_jobs_of(int64_t comparison);
    std::vector<RemovableJob> removable_jobs(int64_t comparison);
    /// Whether any that was made for its jobs to be measured against has begun.
    bool has_begun_reference(const ComparisonRow& comparison);
    /// Those that any of its jobs is measured against, each once.
    std::vector<ReferenceProgress> comparison_references(int64_t seq);
    std::vector<ComparisonRow> comparisons_to_purge();
    /// Instead of what is there of the same films and layer. `map`: JSON.
    void put_row_bias(int64_t comparison, const RowBias& bias, const std::string& map);
    std::vector<RowBias> row_biases(int64_t comparison);
    std::optional<std::string> row_bias_map(int64_t comparison, const std::string& films, const std::string& layer);
    struct ComparisonKeyRow {
        std::string body_sha256;
        int64_t comparison;
    };
    std::optional<ComparisonKeyRow> comparison_key(const std::string& key);
    void insert_comparison_key(const std::string& key, const std::string& body_sha256, int64_t comparison,
                               int64_t at_ms);

    // --- scenes and images
    // --------------------------------------------------------------------------------------------
    void insert_scene(SceneRow& scene);
    void set_scene_summary(const std::string& id, const std::string& summary);
    void delete_scene(const std::string& id);
    std::optional<SceneRow> scene(const std::string& id);
    /// The newest of that name.
    std::optional<SceneRow> scene_named(const std::string& name);
    std::vector<SceneRow> scenes(int64_t before, uint32_t limit);
    std::vector<std::string> scene_ids();

    void insert_image(const ImageRow& image);
    std::optional<ImageRow> image(const std::string& id);
    void set_image_layers(const std::string& id, const std::string& layers);
    void delete_image(const std::string& id);
    /// Id and file of each.
    std::vector<std::pair<std::string, std::string>> image_files();

    // --- events
    // -------------------------------------------------------------------------------------------------------
    void insert_event(const Event& event, int64_t job);
    /// `job` 0: all.
    std::vector<Event> events(uint64_t after_id, uint64_t before_id, int64_t job, size_t limit);
    /// Forgets all but the newest `keep`.
    void prune_events(size_t keep);
    /// No id below this one will be given out by a later start.
    uint64_t event_ids_until();
    void set_event_ids_until(uint64_t id);

    // --- files that no row names: of uploads on their way in, of results on their way out
    // ----------------------------------------------------------------------------------------------------------------
    /// Paths within the data folder; a film's stands for its artefacts too. A start removes them where no row names
    /// them.
    void note_unnamed_file(const std::string& path);
    void forget_unnamed_file(const std::string& path);
    /// Of a noted one, outside a transaction: it need not be removed any more. Forgotten with the next note.
    void unnamed_file_is_gone(std::string path) { gone_files_.push_back(std::move(path)); }
    std::vector<std::string> unnamed_files();

private:
    /// Numbers of all jobs that pass a filter, newest first.
    struct JobList {
        std::string filter;
        uint64_t version;  // jobs_version_ when it was read
        std::vector<int64_t> seqs;
    };

    /// Valid until the next call.
    const std::vector<int64_t>& filtered_jobs(const JobQuery& query);
    /// The kept list of that filter, moved to the front; false where there is none that is still true.
    bool has_list(const std::string& filter);

    Database database_;
    std::string id_;
    std::vector<std::string> gone_files_;
    uint64_t jobs_version_ = 0;       // rises with every change of a job
    std::vector<JobList> job_lists_;  // the latest asked for first
};

std::string job_id(int64_t seq);
/// 0 for what is no job id.
int64_t job_seq(std::string_view id);
std::string group_id(GroupKind kind, int64_t seq);
/// 0 for what is no id of one of that kind.
int64_t group_seq(GroupKind kind, std::string_view id);
std::string comparison_id(int64_t seq);

}  // namespace photond
