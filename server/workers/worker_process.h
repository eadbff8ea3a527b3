#pragma once
// One child process kept alive: spawned, fed, watched, replaced. What its messages mean is its owner's business.

#include <sys/types.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "protocol/message_parts.h"
#include "server/workers/spawn.h"

namespace photond {

/// A process in the background may have to wait for a processor for long: it is given this many times the patience.
inline constexpr int kBackgroundPatience = 20;

struct ProcessOptions {
    std::filesystem::path program;
    std::string device;  // "--device" argument; names it in the log
    std::vector<std::string> more_arguments;
    std::vector<std::filesystem::path> reads, writes;  // folders whose files it may open; no others of ours
    uint64_t memory_limit_bytes = UINT64_MAX;
    uint64_t driver_bytes = 0;  // that a device's driver may hold in this process beside that
    uint32_t threads = 0;       // 0: all cores
    Priority priority;
    double heartbeat_timeout_seconds = 30;  // of one that is not in the background
};

enum class ExitCause : uint8_t {
    Crashed,      // by a signal of its own making, or it gave up by itself
    Lost,         // killed from outside
    Hung,         // no heartbeat; killed by us
    OutOfMemory,  // over its limit; killed by us
    NoSpace,      // over its file size limit
    DeviceLost,   // its GPU stopped answering, as it says itself
    Ordered,      // ended because we said so: stop() or kill()
};

struct ProcessExit {
    ExitCause cause = ExitCause::Lost;
    std::string text;           // for the log and the job's attempt, such as "killed by signal 11 (Segmentation fault)"
    bool had_answered = false;  // it had said hello
};
std::string_view exit_cause_name(ExitCause cause);

/// The worker program's command line.
std::vector<std::string> worker_arguments(const ProcessOptions& options);

/// Of a process of this machine, in physical memory; 0: there is none.
uint64_t resident_bytes_of(pid_t pid);

class WorkerProcess {
public:
    /// All are called from the process's own supervising thread, one at a time, without any lock of this class.
    struct Callbacks {
        /// Everything but heartbeats, hello included. What it throws is what cannot be read: the process is killed
        /// for it, as one that crashed.
        std::function<void(const nlohmann::json&)> message;
        std::function<void(const ProcessExit&)> exited;  // before it is replaced
        std::function<void()> tick;                      // a few times a second
    };

    /// Spawns at once, from a thread of its own: children die with the thread that made them (PR_SET_PDEATHSIG).
    WorkerProcess(ProcessOptions options, Callbacks callbacks);
    ~WorkerProcess();
    WorkerProcess(const WorkerProcess&) = delete;
    WorkerProcess& operator=(const WorkerProcess&) = delete;

    /// False when there is no process to send to; exited() has been or will be called then.
    bool send(const nlohmann::json& message);
    /// SIGKILL; it is replaced. Nothing happens when there is none.
    void kill();
    /// Asks it to end and to be replaced at once.
    void recycle();
    /// Asks it to end, for good; SIGKILL at the deadline. join() waits for it.
    void begin_stop(std::chrono::steady_clock::time_point deadline);
    void join();

    pid_t pid() const;  // -1: none now
    uint64_t resident_bytes() const { return resident_bytes_; }
    /// As its first word says, which it speaks before it reads anything; empty before that.
    std::optional<FileAccess> file_access() const;

private:
    struct Link;  // one child's socket

    void supervise();
    /// Empty when it could not be made.
    std::shared_ptr<Link> spawn();
    ProcessExit attend(Link& link);
    /// False where it cannot be read.
    bool take(const nlohmann::json& message);
    ProcessExit reap(bool had_answered);
    void watch_memory();
    void kill_because(ExitCause cause, const std::string& text);

    const ProcessOptions options_;
    const Callbacks callbacks_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::shared_ptr<Link> link_;
    pid_t pid_ = -1;
    std::optional<FileAccess> file_access_;
    bool stopping_ = false;
    bool ordered_ = false;  // we asked this child to end, or killed it
    std::optional<ExitCause> killed_for_;
    std::string killed_text_;
    std::chrono::steady_clock::time_point stop_deadline_ = std::chrono::steady_clock::time_point::max();
    std::atomic<uint64_t> resident_bytes_ = 0;
    std::thread thread_;
};

}  // namespace photond
