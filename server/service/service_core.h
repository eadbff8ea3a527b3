#pragma once
// What all of the service stands on: the options, the files, and, under one lock, the store, the queue and the
// numbering of events. Processes talk through callbacks on their own supervising threads, which take that lock.

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "protocol/job.h"
#include "server/events.h"
#include "server/metrics.h"
#include "server/options.h"
#include "server/queue/job_queue.h"
#include "server/service/running_attempt.h"
#include "server/store/artefact_cache.h"
#include "server/store/data_files.h"
#include "server/store/store.h"
#include "server/workers/device_list.h"
#include "server/workers/helper.h"

namespace photond {

/// Events of one transaction: numbered and stored inside it, told once it is committed (ServiceCore::tell).
struct Outbox {
    std::vector<Event> events;
    uint64_t ids_until = 0;  // the mark in the store; 0: not moved
};

struct ServiceCore {
    /// Opens the data directory and the store. Throws photond::Error when it cannot, and for devices that are not
    /// there.
    explicit ServiceCore(Options given);
    ServiceCore(const ServiceCore&) = delete;
    ServiceCore& operator=(const ServiceCore&) = delete;

    // --- needs no lock
    /// Throws NoSpace when `bytes` more would leave less than the reserve.
    void check_disk(uint64_t bytes) const;
    /// A worker of ours renders on it, or is to.
    bool has_device(const std::string& id) const;
    /// The device of ours that a method means. Throws DeviceUnavailable, at `pointer`, where there is none.
    std::string device_of(const JobMethod& method, const std::string& pointer = "/method/device") const;
    /// What all processes of ours have alike.
    ProcessOptions process_options() const;
    /// What the list says of a device; may wait for the process that lists them. Throws DeviceUnavailable where it says
    /// nothing.
    nlohmann::json listed_device(const std::string& id);
    /// Takes the lock. An upload is about to be moved there (a path within the data folder), before a row names it.
    void note_upload(const std::string& path);
    /// A job's "state" event.
    static std::string state_data(const JobRow& row);

    // --- under the lock
    /// Has events numbered above all that earlier runs have given out, and read from the store where memory does not
    /// reach back far enough.
    void open_events();
    /// Writes the row and its state event in one transaction and publishes the event. `more` runs inside it;
    /// `new_points` of its curve are told before.
    void commit_state(JobRow& row, const std::string& log_line, const std::function<void(Outbox& outbox)>& more = {},
                      const nlohmann::json& new_points = nlohmann::json::array());
    /// Inside a transaction.
    void put_event(Outbox& outbox, const char* type, int64_t job, std::string data);
    /// After the commit.
    void tell(Outbox outbox);
    /// Keeps the stored mark ahead of the ids given out; inside a transaction. The value of `event_ids_until` once that
    /// is committed.
    uint64_t reserve_event_ids(uint64_t at_least);

    DeviceList device_list;
    const Options options;  // its devices by id, each once
    DataFiles files;
    Metrics metrics;
    EventHub events;
    const JobVocabulary vocabulary;
    ArtefactCache artefacts;
    const SteadyClock::time_point begun = SteadyClock::now();
    std::atomic<int> jobs_on_host_cores = 0;  // that render there now
    std::atomic<bool> ready = false;          // the store is open and every process has answered

    std::mutex publish_mutex;  // one upload at a time is moved into place; taken before `mutex`

    std::mutex mutex;  // "the lock": guards everything below, and what parts of the service say that they do under it
    std::condition_variable attempt_changed;
    Store store;
    JobQueue queue;
    Totals totals;
    bool stopping = false;
    uint64_t event_ids_until = 1;
    std::set<int64_t> comparisons_to_look_at;  // of which a job has ended: RowBiases (attempt_changed)

    /// Made while the processes start, before anybody calls the service. Its call() waits: never under the lock.
    std::unique_ptr<Helper> helper;       // what somebody waits for: images, pictures, measures
    std::unique_ptr<Helper> bulk_helper;  // what may take long: uploads, baking, merging
};

/// Points of a job's curve as a "curve" event tells them; `error_now` as in JobRow.
std::string curve_data(int64_t seq, const nlohmann::json& points, const std::string& error_now);

}  // namespace photond
