#pragma once
// The inside of Service. One lock guards the store and all that follows from it; processes talk through callbacks on
// their own supervising threads, which take that lock.
//
//   service.cpp            start, recovery, stop, system
//   service_scenes.cpp     scenes and images
//   service_submit.cpp     a request judged, and its job written
//   service_references.cpp what jobs are measured against, and waiting for it
//   service_jobs.cpp       get, cancel, purge, retry, extend
//   service_job_lists.cpp  lists of jobs
//   service_merge.cpp      jobs joined into one
//   service_comparisons.cpp  comparisons and their jobs
//   service_comparison_estimate.cpp  what a comparison will take
//   service_reports.cpp    what can be downloaded of a comparison
//   service_estimate.cpp   what a job will take
//   service_attempts.cpp   from the queue to a worker and back: attempts, results, losses
//   service_progress.cpp   what is heard of a running attempt and told of its job
//   service_artefacts.cpp  what can be downloaded
//   service_errors.cpp     curves, differences and maps; measuring on request

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <span>
#include <thread>

#include "protocol/object_reader.h"
#include "renderer/film/film.h"
#include "renderer/frame/render_context.h"
#include "server/comparisons/table.h"
#include "server/queue/job_queue.h"
#include "server/queue/retry_policy.h"
#include "server/service.h"
#include "server/store/artefact_cache.h"
#include "server/store/data_files.h"
#include "server/store/store.h"
#include "server/workers/device_list.h"
#include "server/workers/helper.h"
#include "server/workers/worker_process.h"

namespace photond {

using SteadyClock = std::chrono::steady_clock;

/// A film saved while its job went on; the file goes with its last reader.
struct Snapshot {
    std::filesystem::path path;
    int64_t passes_done = 0;
    SteadyClock::time_point saved;
    ~Snapshot() { remove_quietly(path); }
};

/// The attempt a worker has at hand.
struct RunningAttempt {
    int64_t seq = 0;
    int64_t attempt = 0;
    int64_t pixels = 0;  // of a pass
    int64_t passes_before = 0;
    double seconds_before = 0;  // those of the film it goes on from
    std::string film;           // file name it will write
    int64_t passes_done = 0;
    double progress = 0;
    double seconds = 0;
    nlohmann::json error_now;                        // {"metric", "value"} or null
    nlohmann::json curve = nlohmann::json::array();  // its points so far, those of the film it goes on from first
    bool curve_begun = false;  // this attempt has sent points: they take the place of earlier ones
    nlohmann::json unpublished = nlohmann::json::array();  // points that no event has told yet
    SteadyClock::time_point last_curve_event;
    SteadyClock::time_point begun, last_event;
    SteadyClock::time_point deadline = SteadyClock::time_point::max();  // of the attempt's own time
    SteadyClock::time_point kill_at = SteadyClock::time_point::max();   // when it has not answered a cancel
    bool deadline_passed = false;
    uint64_t snapshots = 0;
    bool device_shared = false;  // another job ran meanwhile on the same cores ...
    bool host_shared = false;    // ... or at all
    std::string device_lost;     // the worker's reason; empty: it has said none
    std::shared_ptr<const Snapshot> snapshot;
    /// How it ended, when the store could not be written (disk full): tried again until it can.
    std::function<void()> unsettled;
};

/// What has been rendered since the daemon started, as far as it is known.
struct Totals {
    std::map<std::string, uint64_t> jobs{{"succeeded", 0}, {"failed", 0}, {"cancelled", 0}};
    std::map<std::string, uint64_t> rays{{"camera", 0}, {"bounce", 0}, {"shadow", 0}, {"photon", 0}};
    uint64_t photons = 0;
    int64_t passes = 0;
    int64_t pixels = 0;  // of all passes
    double render_seconds = 0;

    void add(const RunningAttempt& attempt);
    /// An attempt that has ended; `rendered` as in "finished", null where that was not said.
    void add(const RunningAttempt& attempt, const nlohmann::json& rendered);
};

struct Slot {
    std::string device;
    std::unique_ptr<WorkerProcess> process;
    bool answered = false;         // the process at hand has said hello
    nlohmann::json device_object;  // of protocol.md; null until the CPU's worker has answered
    bool on_host_cores = true;     // the CPU, or a GPU that is software
    uint64_t restarts = 0;
    uint64_t jobs_done = 0;  // by the process at hand
    std::optional<RunningAttempt> running;
};

/// Events of one transaction: numbered and stored inside it, told once it is committed (Service::Impl::tell).
struct Outbox {
    std::vector<Event> events;
    uint64_t ids_until = 0;  // the mark in the store; 0: not moved
};

/// A job that has been judged and waits to be written.
struct PreparedJob {
    JobRow row;               // seq 0
    uint64_t disk_bytes = 0;  // that it will leave
    /// The job that makes what it is measured against, where nobody has asked for that before.
    std::optional<JobRow> reference;
    uint64_t reference_disk_bytes = 0;
};

/// Of a job that succeeded, what tells how long another will take.
struct EarlierJob {
    std::string scene;
    nlohmann::json parameters;
    double pixels = 0, seconds = 0, passes = 0;
    double photon_seconds = 0;  // of its seconds, those that its photons took
};
/// By method and device; read from the store once for all that is estimated together.
using EarlierJobs = std::map<std::pair<std::string, std::string>, std::vector<EarlierJob>>;

/// Jobs written in a transaction that is not committed yet.
struct Insertion {
    std::vector<JobRow> rows;  // references before the jobs that need them; raised ones among them
    Outbox outbox;
};

struct Report;  // server/comparisons/report_html.h

struct Service::Impl {
    explicit Impl(Options given);
    ~Impl();

    // service.cpp
    void recover();
    void sweep_orphans();
    void start_processes();
    void stop();
    void update_ready();
    /// A worker of ours renders on it, or is to.
    bool has_device(const std::string& id) const;
    /// What the list says of it. Throws DeviceUnavailable where it says nothing.
    nlohmann::json listed_device(const std::string& id);
    Page devices();  // takes the lock; may wait for the process that lists them
    nlohmann::json status();
    std::string metrics_text();
    /// Those of attempts that are running included.
    nlohmann::json totals_now() const;  // under the lock

    // service_scenes.cpp
    struct SceneRef {
        std::string id;
        bool builtin = false;
        std::optional<SceneRow> row;
    };
    std::optional<SceneRef> find_scene(const std::string& id_or_name);  // under the lock
    SceneRef require_scene(const std::string& id_or_name);              // takes the lock
    nlohmann::json builtin_object(const std::string& name);             // without the lock: may wait
    /// Has it judged if it is a built-in one, so that a job of it is estimated by what it is; without the lock. Where
    /// the helper cannot, the job is estimated without.
    void know_scene(const std::string& id_or_name);
    nlohmann::json scene_object(const SceneRow& row) const;
    nlohmann::json scene_order(const SceneRef& scene) const;  // "scene" of a render order
    Added add_scene(SceneUpload upload);
    Page list_scenes(const std::string& family, uint32_t limit, const std::string& cursor);
    Page list_family(const std::string& family, uint32_t limit, const std::string& cursor);
    nlohmann::json get_scene(const std::string& id_or_name);
    Artefact thumbnail(const std::string& id_or_name);
    Artefact baked_scene(const std::string& id_or_name);
    nlohmann::json delete_scene(const std::string& id_or_name);
    Added add_image(const std::filesystem::path& spooled, const std::string& media_type);
    /// Without the lock: what was uploaded before layers were noted is looked at again, by the helper.
    std::optional<ImageRow> find_image(const std::string& id);
    ImageRow require_image(const std::string& id);  // likewise
    void check_disk(uint64_t bytes) const;

    // service_submit.cpp
    nlohmann::json submit_job(const JobRequest& request, const std::optional<std::string>& key,
                              const std::string& canonical_body);
    /// For whoever inserts several jobs at once, all under the lock:
    ///     std::vector<PreparedJob> jobs;  // prepare_job() each; set row.comparison
    ///     check_room(jobs);
    ///     Insertion inserted;
    ///     auto transaction = store.transaction();
    ///     for (PreparedJob& job : jobs) insert_job(job, inserted);  // fills in job.row.seq
    ///     transaction.commit();
    ///     accept(std::move(inserted));
    /// Judges a request and all it depends on: UnknownName, Conflict, OutOfRange, DeviceUnavailable, OutOfMemory.
    PreparedJob prepare_job(const JobRequest& request);
    /// Unavailable when stopping, QueueFull, NoSpace.
    void check_room(std::span<const PreparedJob> jobs) const;
    void check_room(size_t jobs, uint64_t disk_bytes) const;
    /// Inside the caller's transaction: writes the job with its log and event, and before it its reference
    /// unless one of that content is there by now.
    void insert_job(PreparedJob& job, Insertion& inserted);
    /// After the commit: tells the events, queues the jobs and has them begin.
    void accept(Insertion inserted);
    /// Everything of a request that depends on this daemon; the scene it means. Under the lock.
    SceneRef check_request(const JobRequest& request);
    /// Throws Unsupported for parameters that only the CPU has, where the method is to run on a GPU; faults at
    /// prefix + "/method/parameters/...".
    static void check_parameters(const JobMethod& method, const std::string& prefix);
    /// Pixels and memory, at `pointer`.
    void check_size(const JobRequest& request, const SceneRef& scene, const std::string& pointer);
    void check_device_memory(const JobRequest& request, const SceneRef& scene, const std::string& pointer);
    std::string device_of(const JobMethod& method, const std::string& pointer = "/method/device") const;
    /// The job an idempotency key was used for; IdempotencyMismatch when that was with another body.
    std::optional<JobRow> job_of_key(const std::string& key, const std::string& body_sha256);

    // service_references.cpp; all under the lock
    /// Faults of request.reference and of the layers its metrics need.
    void check_reference(const JobRequest& request, const SceneRef& scene);
    /// SHA-256 of what a reference shows and how it is made: two with the same are the same image.
    static std::string reference_content(const JobRequest& reference, const std::string& scene_id);
    /// What request.reference->rendering asks for, as a job of its own.
    static JobRequest reference_request(const JobRequest& request);
    /// Where the request's reference is to be rendered: fills in `reference_job` where a job of that content is there,
    /// else returns the job to insert. Nothing happens for references of other kinds.
    std::optional<JobRow> missing_reference(const JobRequest& request, const SceneRef& scene,
                                            std::optional<int64_t>& reference_job);
    /// One that is finished, or will be.
    std::optional<JobRow> usable_reference(const std::string& content);
    /// Inside a transaction: the job of that content that is there by now, else this one, inserted. Its seq.
    int64_t insert_reference(JobRow reference, Insertion& inserted);
    /// Inside a transaction: a reference that waits with a lower priority than a job that needs it gets that job's.
    void raise_reference(int64_t seq, int priority, Insertion& inserted);
    /// The job that is not over yet and that this one is measured against.
    std::optional<int64_t> waits_for(const JobRow& row);
    std::string waiting_text(const JobRow& row);  // for the log; empty when it does not wait
    /// Puts a queued job where it belongs: into the queue, or beside it until what it is measured against is over.
    void enqueue(const JobRow& row);
    /// A job is over: those that were waiting for it are queued, or fail where it left nothing to measure against.
    void release_waiting(const JobRow& row);
    /// {"film": path}, {"image": path} or null: what a job is measured against, once that is over. Throws WrongState,
    /// with the reason, where it is lost.
    nlohmann::json reference_source(const JobRow& row);
    void fail_for_reference(JobRow row, const std::string& reason);
    /// Throws WrongState, naming one, while jobs that are not over are measured against this one; with `running` only
    /// those that run now count.
    void check_unused(const JobRow& row, bool running);

    // service_jobs.cpp
    nlohmann::json get_job(const std::string& id);
    Cancelled cancel_job(const std::string& id, bool purge);
    nlohmann::json change_job(const std::string& id, const nlohmann::json& body);
    nlohmann::json retry_job(const std::string& id);
    /// `body`: {"stop": ...}; the conditions count from the film's first pass.
    nlohmann::json extend_job(const std::string& id, const nlohmann::json& body);
    /// WrongState for a merged film with gaps between its passes.
    static void check_one_range(const JobRow& row);
    /// Back to the queue, its film kept; `log_line` says why. Makes its reference anew where that is gone.
    nlohmann::json queue_again(JobRow row, const std::string& log_line);
    JobRow require_job(const std::string& id);  // under the lock
    nlohmann::json job_object(const JobRow& row) const;
    void purge(const JobRow& row);
    /// The film of an attempt (empty: none) and whatever artefacts lie beside it.
    void remove_film(const std::string& film) const;
    void remove_parts(const std::string& film) const;  // what a killed worker was writing for it

    // service_job_lists.cpp
    Page list_jobs(const JobFilter& filter);            // takes the lock
    nlohmann::json job_summary(const JobSummary& row);  // under the lock

    // service_merge.cpp
    nlohmann::json merge_jobs(const nlohmann::json& body, const std::optional<std::string>& key);  // waits
    std::vector<JobRow> jobs_to_merge(const std::vector<std::string>& ids);  // under the lock; faults at /jobs/i
    static JobRow merged_row(const std::vector<JobRow>& parts, const nlohmann::json& result);
    nlohmann::json add_merged(JobRow row, const std::filesystem::path& film, const std::vector<std::string>& ids,
                              const std::optional<std::string>& key, const std::string& body_sha256);

    // service_comparisons.cpp; under the lock where it says nothing else
    /// Where the jobs are, and the job they are measured against.
    struct ComparisonState {
        std::vector<JobProgress> jobs;
        std::optional<JobProgress> reference;
        bool made_for_it = false;  // the reference, by this comparison
    };
    /// All that is known of a comparison and its jobs.
    struct Compared {
        ComparisonRow row;
        ComparisonState state;
        std::vector<std::pair<ComparisonJob, JobRow>> jobs;
    };
    /// What follows from that.
    struct Judged {
        nlohmann::json object;
        std::vector<MeasuredJob> jobs;
        ComparisonTable table;
    };
    nlohmann::json submit_comparison(const ComparisonRequest& request,
                                     const std::optional<std::string>& key);  // takes the lock
    /// Its jobs, judged; faults are at their places in the comparison's body.
    std::vector<PreparedJob> prepare_jobs(const ComparisonRequest& request);
    nlohmann::json get_comparison(const std::string& id);              // takes the lock
    Page list_comparisons(uint32_t limit, const std::string& cursor);  // takes the lock
    Cancelled cancel_comparison(const std::string& id, bool purge);    // takes the lock
    Compared read_comparison(const std::string& id);                   // takes the lock
    static Judged judge(const Compared& compared);                     // without the lock
    ComparisonRow require_comparison(const std::string& id);
    JobProgress progress_now(JobProgress job) const;
    ComparisonState comparison_state(const ComparisonRow& row);
    nlohmann::json comparison_summary(const ComparisonRow& row);
    Compared read_comparison(const ComparisonRow& row);
    /// Cancels what waits and asks for what runs to be cancelled, in one transaction with `more`.
    void cancel_jobs(std::vector<JobRow> rows, const std::function<void()>& more, bool remove);
    std::vector<JobRow> jobs_of_comparison(int64_t seq);
    /// Removes those of its jobs that are over, and the comparison with the last one.
    void finish_purge(const ComparisonRow& row);
    void finish_purges();
    /// WrongState: a job of a comparison is not removed by itself.
    void check_not_compared(const JobRow& row);

    // service_comparison_estimate.cpp
    nlohmann::json estimate_comparison(const ComparisonRequest& request);  // takes the lock; may wait for the helper

    // service_reports.cpp; without the lock
    Artefact comparison_json(const std::string& id);
    Artefact comparison_csv(const std::string& id);
    Artefact comparison_html(const std::string& id);
    /// Images and maps of what has succeeded, first seed of each row; waits for the helper.
    void add_pictures(Report& report, const Judged& judged);

    // service_estimate.cpp
    nlohmann::json estimate_job(const JobRequest& request);  // takes the lock; may wait for the helper
    /// Of rendering; nothing where it stops by passes and the method has rendered none here. Under the lock.
    std::optional<double> estimate_seconds(const JobRequest& request, const SceneRef& scene, EarlierJobs& earlier);
    /// What the worker's budget will hold, to a few percent; under the lock.
    uint64_t estimate_memory_bytes(const JobRequest& request, const SceneRef& scene);
    /// What it will take of a GPU's memory, its scene included; nothing on the CPU.
    std::optional<uint64_t> estimate_device_bytes(const JobRequest& request, const SceneRef& scene);
    Workload workload_of(const JobRequest& request, const nlohmann::json& scene_summary);  // under the lock
    nlohmann::json summary_of(const SceneRef& scene);
    static uint64_t film_bytes(const JobRequest& request);
    /// What a job will leave on the disk; under the lock.
    uint64_t estimate_disk_bytes(const JobRequest& request, const SceneRef& scene);

    // service_attempts.cpp; all under the lock
    void dispatch();
    void dispatch(Slot& slot);
    void begin_attempt(Slot& slot, JobRow row);
    void worker_message(Slot& slot, const nlohmann::json& message);  // takes the lock
    void worker_exited(Slot& slot, const ProcessExit& exit);         // takes the lock
    void worker_tick(Slot& slot);                                    // takes the lock
    /// Another job has begun there: what runs beside it shares the host, and the device where that is the host's cores.
    void mark_shared(Slot& slot);
    void progress(Slot& slot, const nlohmann::json& message);
    void film_saved(Slot& slot, const nlohmann::json& message);
    /// The attempt has saved its film: from here on the job goes on from there, whatever becomes of the attempt.
    void keep_film(const RunningAttempt& attempt, int64_t passes_done);
    void finished(Slot& slot, const nlohmann::json& message);
    void record_result(const RunningAttempt& attempt, const nlohmann::json& message, const std::string& device);
    /// Of the artefacts a "finished" names, those that the method declares and that are there.
    nlohmann::json kept_artefacts(const JobRow& row, const nlohmann::json& message) const;
    void record_loss(const RunningAttempt& attempt, const ProcessExit& exit, bool daemon_stopping);
    /// Runs `record`, lets the slot go and gives it the next job; when the store fails the slot keeps `record`.
    void settle(Slot& slot, std::function<void()> record);
    RunningAttempt* running_attempt(int64_t seq);
    Slot* slot_of(int64_t seq);
    void cancel_running(Slot& slot);
    /// The row is over: metrics, event.
    void ended(const JobRow& row);

    /// Writes the row and its state event in one transaction and publishes the event. `more` runs inside it;
    /// `new_points` of its curve are told before.
    void commit_state(JobRow& row, const std::string& log_line, const std::function<void()>& more = {},
                      const nlohmann::json& new_points = nlohmann::json::array());
    static std::string state_data(const JobRow& row);
    /// Inside a transaction.
    void put_event(Outbox& outbox, const char* type, int64_t job, std::string data);
    /// After the commit.
    void tell(Outbox outbox);
    void publish_progress(const RunningAttempt& attempt);
    void curve(Slot& slot, const nlohmann::json& message);
    void publish_curve(RunningAttempt& attempt);
    /// Keeps the stored mark ahead of the ids given out; inside a transaction. The value of `event_ids_until` once that
    /// is committed.
    uint64_t reserve_event_ids(uint64_t at_least);

    // service_artefacts.cpp
    struct FilmSource {
        bool pending = false;
        std::filesystem::path path;
        std::string cache_key;
        nlohmann::json statistics;
        std::shared_ptr<const void> pin;
    };
    FilmSource film_source(const std::string& id);
    /// Gives the film a second name that goes with the last user: it can be read whatever becomes of its job.
    void pin(FilmSource& film);
    Artefact encode(const std::string& id, const std::string& what, const std::string& media_type,
                    nlohmann::json request, bool with_statistics);
    Artefact image_pixels(const std::string& id, const std::string& layer, const std::string& precision);
    /// What the helper says of pixels, as headers of a reply.
    static std::map<std::string, std::string> pixel_headers(const nlohmann::json& result);
    Artefact statistics(const std::string& id);
    Artefact method_artefact(const std::string& id, const std::string& name);
    Artefact log(const std::string& id);
    Artefact artefact(const std::string& key, const std::string& media_type, const ArtefactCache::Make& make);
    /// A file of the store as it is: no copy, and a download that has begun outlives the job.
    Artefact linked(const std::string& key, const std::filesystem::path& file, const std::string& media_type);
    /// Named by what it holds: a retried job has others.
    Artefact text_artefact(const std::string& prefix, const std::string& text, const std::string& media_type);

    // service_errors.cpp
    struct MeasuredPair {
        FilmSource film;
        nlohmann::json reference;  // as reference_source()
        FilmSource pinned_reference;
        std::string key;  // in the cache
    };
    /// A job's film and its reference; NotFound, with the reason, where it has none. Pending likewise.
    MeasuredPair measured_pair(const std::string& id);
    Artefact encode_error(const std::string& id, const std::string& what, const std::string& media_type,
                          nlohmann::json request);
    Artefact curve_file(const std::string& id);
    /// What "job:ID" or "image:ID" names.
    struct NamedSource {
        FilmSource film;        // of a job; pending where it has none yet. Held as long as this lives
        nlohmann::json source;  // as the helper takes it
        std::string key;        // in the cache
    };
    NamedSource source_named(const std::string& name, const std::string& pointer);
    nlohmann::json measure(const nlohmann::json& body);
    Artefact flip_map(const std::string& image, const std::string& reference, const std::string& layer,
                      const std::string& range, const std::string& precision);

    DeviceList device_list;
    const Options options;  // its devices by id, each once
    DataFiles files;
    Metrics metrics;
    EventHub events;
    JobVocabulary vocabulary;
    ArtefactCache artefacts;
    const SteadyClock::time_point begun = SteadyClock::now();
    std::atomic<bool> ready = false;

    mutable std::mutex mutex;  // guards everything below
    std::condition_variable attempt_changed;
    Store store;
    JobQueue queue;
    std::vector<std::unique_ptr<Slot>> slots;
    Totals totals;
    bool stopping = false;
    uint64_t event_ids_until = 1;

    std::mutex publish_mutex;  // one upload at a time is moved into place; taken before `mutex`
    std::mutex builtin_mutex;
    std::map<std::string, nlohmann::json> builtin_summaries;

    std::unique_ptr<Helper> helper;
    std::thread prewarm;  // has the built-in scenes judged before anybody asks
    std::once_flag stopped;
};

/// Throws OutOfRange for what is no Idempotency-Key.
void check_idempotency_key(const std::string& key);
inline constexpr auto kProgressInterval = std::chrono::milliseconds(250);  // four events a second for each job

/// Text of a row's JSON member; empty for null and for what holds nothing.
std::string text_of(const nlohmann::json& value);
/// A message's member where it is an object, else null.
nlohmann::json object_or_null(const nlohmann::json& message, const char* member);

/// A fault for what is neither "float" nor "half".
void check_precision(const std::string& precision, BodyFaults& faults);

/// A page's limit. Throws OutOfRange outside 1..1000.
void check_limit(uint32_t limit);
/// A cursor that is a number; `otherwise` when it is empty. Throws OutOfRange.
int64_t read_cursor(const std::string& cursor, int64_t otherwise);

}  // namespace photond
