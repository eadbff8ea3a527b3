#pragma once
// The inside of Service. One lock guards the store and all that follows from it; processes talk through callbacks on
// their own supervising threads, which take that lock.
//
//   service.cpp            start, recovery, stop, system
//   service_scenes.cpp     scenes and images
//   service_jobs.cpp       submit, get, list, cancel, purge, retry
//   service_estimate.cpp   what a job will take
//   service_attempts.cpp   from the queue to a worker and back: attempts, progress, results, losses
//   service_artefacts.cpp  what can be downloaded

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "renderer/film/film.h"
#include "renderer/methods/method.h"
#include "server/queue/job_queue.h"
#include "server/queue/retry_policy.h"
#include "server/service.h"
#include "server/store/artefact_cache.h"
#include "server/store/data_files.h"
#include "server/store/store.h"
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
    std::string film;  // file name it will write
    int64_t passes_done = 0;
    double progress = 0;
    double seconds = 0;
    SteadyClock::time_point begun, last_event;
    SteadyClock::time_point deadline = SteadyClock::time_point::max();  // of the attempt's own time
    SteadyClock::time_point kill_at = SteadyClock::time_point::max();   // when it has not answered a cancel
    bool deadline_passed = false;
    uint64_t snapshots = 0;
    std::shared_ptr<const Snapshot> snapshot;
    /// How it ended, when the store could not be written (disk full): tried again until it can.
    std::function<void()> unsettled;
};

struct Slot {
    std::string device;
    std::unique_ptr<WorkerProcess> process;
    bool answered = false;  // the process at hand has said hello
    nlohmann::json device_object;
    uint64_t restarts = 0;
    uint64_t jobs_done = 0;  // by the process at hand
    std::optional<RunningAttempt> running;
};

struct Service::Impl {
    explicit Impl(Options given);
    ~Impl();

    // service.cpp
    void recover();
    void sweep_orphans();
    void start_processes();
    void stop();
    void update_ready();
    Page devices();
    nlohmann::json status();
    std::string metrics_text();

    // service_scenes.cpp
    struct SceneRef {
        std::string id;
        bool builtin = false;
        std::optional<SceneRow> row;
    };
    std::optional<SceneRef> find_scene(const std::string& id_or_name);  // under the lock
    SceneRef require_scene(const std::string& id_or_name);              // takes the lock
    nlohmann::json builtin_object(const std::string& name);             // without the lock: may wait
    nlohmann::json scene_object(const SceneRow& row) const;
    nlohmann::json scene_order(const SceneRef& scene) const;  // "scene" of a render order
    Added add_scene(SceneUpload upload);
    Page list_scenes(uint32_t limit, const std::string& cursor);
    nlohmann::json get_scene(const std::string& id_or_name);
    Artefact thumbnail(const std::string& id_or_name);
    nlohmann::json delete_scene(const std::string& id_or_name);
    Added add_image(const std::filesystem::path& spooled, const std::string& media_type);
    ImageRow require_image(const std::string& id);
    void check_disk(uint64_t bytes) const;

    // service_jobs.cpp
    nlohmann::json submit_job(const JobRequest& request, const std::optional<std::string>& key,
                              const std::string& canonical_body);
    nlohmann::json get_job(const std::string& id);
    Page list_jobs(const JobFilter& filter);
    Cancelled cancel_job(const std::string& id, bool purge);
    nlohmann::json retry_job(const std::string& id);
    JobRow require_job(const std::string& id);  // under the lock
    nlohmann::json job_object(const JobRow& row) const;
    /// Everything of a request that depends on this daemon; the scene it means. Under the lock.
    SceneRef check_request(const JobRequest& request);
    std::string device_of(const JobRequest& request) const;
    void purge(const JobRow& row);
    /// The film of an attempt (empty: none) and whatever artefacts lie beside it.
    void remove_film(const std::string& film) const;

    // service_estimate.cpp
    nlohmann::json estimate_job(const JobRequest& request);  // takes the lock; may wait for the helper
    /// What the worker's budget will hold, to a few percent; under the lock.
    uint64_t estimate_memory_bytes(const JobRequest& request, const SceneRef& scene);
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
    void progress(Slot& slot, const nlohmann::json& message);
    void film_saved(Slot& slot, const nlohmann::json& message);
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

    /// Writes the row and its state event in one transaction and publishes the event. `more` runs inside it.
    void commit_state(JobRow& row, const std::string& log_line, const std::function<void()>& more = {});
    Event state_event(const JobRow& row) const;
    void publish_progress(const RunningAttempt& attempt);
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
    Artefact encode(const std::string& id, const std::string& what, const std::string& media_type,
                    nlohmann::json request, bool with_statistics);
    Artefact statistics(const std::string& id);
    Artefact method_artefact(const std::string& id, const std::string& name);
    Artefact log(const std::string& id);
    Artefact artefact(const std::string& key, const std::string& media_type, const ArtefactCache::Make& make);

    const Options options;
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
    bool stopping = false;
    uint64_t event_ids_until = 1;

    std::mutex publish_mutex;  // one upload at a time is moved into place; taken before `mutex`
    std::mutex builtin_mutex;
    std::map<std::string, nlohmann::json> builtin_summaries;

    std::unique_ptr<Helper> helper;
    std::thread prewarm;  // has the built-in scenes judged before anybody asks
    std::once_flag stopped;
};

/// A page's limit. Throws OutOfRange outside 1..1000.
void check_limit(uint32_t limit);
/// A cursor that is a number; `otherwise` when it is empty. Throws OutOfRange.
int64_t read_cursor(const std::string& cursor, int64_t otherwise);

}  // namespace photond
