#pragma once
// From the queue to a worker and back: the workers, one a device, and the attempt that each has at hand.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "protocol/worker_messages.h"
#include "server/service/attempt_progress.h"
#include "server/service/attempt_records.h"
#include "server/service/pictures.h"
#include "server/service/process_meter.h"
#include "server/service/purges.h"
#include "server/service/quiet_machine.h"
#include "server/service/references.h"
#include "server/service/running_attempt.h"
#include "server/service/scenes.h"
#include "server/service/service_core.h"
#include "server/service/waiting_jobs.h"
#include "server/workers/worker_process.h"

namespace photond {

/// A job that begins when nothing else runs on the machine, or when it has waited long enough.
struct QuietWait {
    int64_t seq = 0;
    SteadyClock::time_point since;
};

struct Slot {
    std::string device;
    std::unique_ptr<WorkerProcess> process;
    bool answered = false;         // the process at hand has said hello
    nlohmann::json device_object;  // protocol.md, "Shapes"; null until the CPU's worker has answered
    bool on_host_cores = true;     // the CPU, or a GPU that is software
    uint64_t restarts = 0;
    uint64_t jobs_done = 0;  // by the process at hand
    std::optional<RunningAttempt> running;
    std::optional<QuietWait> waiting;  // the job whose turn it is, where that waits
};

/// All under the lock where they say nothing else.
class Attempts {
public:
    Attempts(ServiceCore& core, const Pictures& pictures, Scenes& scenes, References& references, WaitingJobs& waiting,
             Purges& purges)
        : core_(core),
          pictures_(pictures),
          scenes_(scenes),
          references_(references),
          waiting_(waiting),
          records_(core, waiting, purges),
          progress_(core, records_) {}

    /// A job was running when an earlier daemon ended without warning: that attempt is lost.
    void lost_with_daemon(const JobRow& row);
    /// Starts a worker for each device; `process` is what all have alike. Throws DeviceUnavailable.
    void start(const ProcessOptions& process);
    /// Has all workers end by `deadline`; join() waits for that, without the lock.
    void begin_stop(SteadyClock::time_point deadline);
    void join();
    /// Takes the lock. The service is ready while every worker and the helper have answered and it is not stopping.
    void update_ready();

    /// Gives waiting jobs to workers that have none. Does not throw: what cannot begin is tried again at the next tick.
    void dispatch();
    /// Null where the job does not run.
    const RunningAttempt* running_attempt(int64_t seq) const;
    /// Tells the job's worker to let go of it, and kills that when it does not. Nothing happens where it does not run.
    void cancel_running(int64_t seq);
    /// Has the worker of a running job save its film beside it, once for all who ask during a pass; where, is returned.
    /// Its snapshot is there once ServiceCore::attempt_changed says so.
    std::filesystem::path ask_for_snapshot(int64_t seq);
    const std::vector<std::unique_ptr<Slot>>& slots() const { return slots_; }
    /// What a queued job waits for, so that "waits for" can be said before it.
    std::string waiting_for(int64_t seq, const std::string& device) const;

private:
    void start_worker(const std::string& device, ProcessOptions process);
    void dispatch(Slot& slot);
    void begin_attempt(Slot& slot, JobRow row);
    /// Whether the job whose turn it is begins only when the machine is quiet, and that is not yet so. Its log says
    /// when it begins to wait and how that ends.
    bool waits_for_quiet(Slot& slot, const JobRow& row);
    void worker_message(Slot& slot, const nlohmann::json& message);  // takes the lock; throws as Callbacks::message
    void worker_exited(Slot& slot, const ProcessExit& exit);         // takes the lock
    void worker_tick(Slot& slot);                                    // takes the lock
    /// Another job has begun there: what runs beside it shares the host, and the device where that is the host's cores.
    void mark_shared(Slot& slot);
    /// Takes the lock. Of a worker that has ended: the film that its attempt saved.
    std::optional<FilmFacts> film_left_in(const Slot& slot);
    void finished(Slot& slot, const FinishedMessage& message);
    /// Before an attempt begins or when one ends: notes with those that run what other processes of ours have taken
    /// since the last time.
    void note_processor_time();
    /// Runs `record`, lets the slot go and gives it the next job; when the store fails the slot keeps `record`.
    void settle(Slot& slot, std::function<void()> record);
    Slot* slot_of(int64_t seq) const;
    static void cancel_running(Slot& slot);

    ServiceCore& core_;
    const Pictures& pictures_;
    Scenes& scenes_;
    References& references_;
    WaitingJobs& waiting_;
    AttemptRecords records_;
    AttemptProgress progress_;
    ProcessMeter meter_;
    QuietMachine quiet_machine_;
    std::vector<std::unique_ptr<Slot>> slots_;  // the last member: ends its threads before the rest goes
};

}  // namespace photond
