#pragma once
// A sandboxed process that judges uploads, encodes images and draws pictures (photond-worker --device none): one
// request at a time, callers wait their turn.

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "protocol/error.h"
#include "protocol/helper_messages.h"
#include "server/workers/worker_process.h"

namespace photond {

class Helper {
public:
    /// `exited` is told each time its process ends; `answered` each time one is ready. A request may take
    /// `request_timeout_seconds`; of a process in the background, which may be kept waiting, so much processor time,
    /// and kBackgroundPatience times as much of the clock.
    Helper(ProcessOptions options, double request_timeout_seconds, std::function<void()> answered,
           std::function<void(const ProcessExit&)> exited);
    ~Helper();

    /// Sends one request and waits for its reply. The helper's own failure is thrown as the Error it names. A helper
    /// that is lost through no fault of the request is replaced and asked again; one that crashes on it, or answers
    /// what is no reply to it, is not: WorkerCrashed. TimedOut after the time limit, OutOfMemory past the memory limit,
    /// Unavailable when there is no helper. NeedsHelper on a thread that may not wait.
    /// With `most_processor_seconds` TimedOut also when the request has taken so much processor time.
    template <class Request>
    typename Request::Reply ask(Request request, std::optional<double> most_processor_seconds = std::nullopt) {
        const nlohmann::json result = call(message_json(std::move(request)), most_processor_seconds);
        try {
            return read_part<typename Request::Reply>(result, Request::kType);
        } catch (const Error& error) {
            distrust(error);
        }
    }

    bool ready() const;
    /// How long the request under way has taken; nothing when there is none. Takes no lock.
    std::optional<double> busy_seconds() const;
    pid_t pid() const { return process_->pid(); }
    uint64_t resident_bytes() const { return process_->resident_bytes(); }
    std::optional<FileAccess> file_access() const { return process_->file_access(); }
    uint64_t restarts() const;

    void begin_stop(std::chrono::steady_clock::time_point deadline);
    void join() { process_->join(); }

private:
    /// The result of a request, whose number is filled in; an object.
    nlohmann::json call(nlohmann::json request, std::optional<double> most_processor_seconds);
    /// Has the process replaced that gave a result which cannot be read.
    [[noreturn]] void distrust(const Error& error);
    void message(const nlohmann::json& message);
    void process_exited(const ProcessExit& exit);
    struct Patience {
        double clock_seconds;
        std::optional<double> processor_seconds;
    };
    Patience patience(std::optional<double> most_processor_seconds) const;
    std::optional<ReplyMessage> attempt(std::unique_lock<std::mutex>& lock, nlohmann::json& request,
                                        const Patience& patience);
    /// What the request under way has taken too much of; empty when it is over.
    std::string wait_for_end(std::unique_lock<std::mutex>& lock, const Patience& patience);

    const double timeout_seconds_;
    const bool background_;
    const uint64_t memory_limit_bytes_;
    const std::function<void()> answered_;
    const std::function<void(const ProcessExit&)> exited_;
    std::atomic<int64_t> asked_at_ = 0;  // the request under way, in the steady clock's ticks; 0: none
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    uint64_t next_ticket_ = 0, serving_ = 0;  // callers are served in the order they came
    uint64_t request_ = 0;                    // number of the request under way
    uint64_t served_ = 0;                     // requests of the process at hand
    uint64_t restarts_ = 0;
    bool ready_ = false;
    bool stopping_ = false;
    std::optional<ReplyMessage> reply_;
    std::optional<ProcessExit> exit_;  // of the process that had the request
    std::unique_ptr<WorkerProcess> process_;
};

}  // namespace photond
