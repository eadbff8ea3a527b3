#include "server/workers/worker_process.h"

#include <poll.h>
#include <signal.h>
#include <spdlog/spdlog.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>

#include "protocol/error.h"
#include "protocol/message_channel.h"
#include "protocol/worker_messages.h"

namespace photond {

namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::duration_cast;
using std::chrono::milliseconds;

constexpr milliseconds kTick{250};  // how often memory and deadlines are looked at while nothing is said
// What a process holds besides what its limit is about, the structures of a job (MemoryBudget): code, libraries, stacks
// and the allocator's leftovers, measured 130 to 145 MB; and scenes kept for later jobs (kIdleScenesDivisor).
constexpr uint64_t kOwnBytes = 256ull << 20;
constexpr uint64_t kIdleScenesDivisor = 8;
constexpr milliseconds kFirstBackoff{100};  // doubled for each process in a row that never said hello
constexpr milliseconds kLastBackoff{10'000};
constexpr milliseconds kLingering{2000};  // a process that hung up but does not end is killed after this
constexpr std::chrono::seconds kLeastStartTime{30};

milliseconds seconds_to_ms(double seconds) { return milliseconds(static_cast<int64_t>(seconds * 1000)); }

/// Signals that a program brings on itself; others come from outside.
bool is_own_fault(int signal) {
    return signal == SIGSEGV || signal == SIGABRT || signal == SIGBUS || signal == SIGFPE || signal == SIGILL ||
           signal == SIGTRAP || signal == SIGSYS || signal == SIGXCPU || signal == SIGPIPE || signal == SIGALRM;
}

}  // namespace

uint64_t resident_bytes_of(pid_t pid) {
    char path[64];
    std::snprintf(path, sizeof path, "/proc/%d/statm", static_cast<int>(pid));
    FILE* file = std::fopen(path, "re");
    if (!file) return 0;
    unsigned long long size = 0, resident = 0;
    const int read = std::fscanf(file, "%llu %llu", &size, &resident);
    std::fclose(file);
    return read == 2 ? resident * static_cast<uint64_t>(sysconf(_SC_PAGESIZE)) : 0;
}

std::string_view exit_cause_name(ExitCause cause) {
    constexpr std::string_view kNames[] = {"crashed",  "lost",        "hung",   "out_of_memory",
                                           "no_space", "device_lost", "ordered"};
    return kNames[static_cast<size_t>(cause)];
}

std::vector<std::string> worker_arguments(const ProcessOptions& options) {
    std::vector<std::string> arguments{"--device",       options.device,
                                       "--memory-limit", std::to_string(options.memory_limit_bytes),
                                       "--threads",      std::to_string(options.threads)};
    for (const auto& folder : options.reads) arguments.insert(arguments.end(), {"--read", folder.string()});
    for (const auto& folder : options.writes) arguments.insert(arguments.end(), {"--write", folder.string()});
    arguments.insert(arguments.end(), options.more_arguments.begin(), options.more_arguments.end());
    return arguments;
}

struct WorkerProcess::Link {
    explicit Link(int socket) : channel(socket) {}
    ~Link() { close(channel.socket()); }
    MessageChannel channel;
};

WorkerProcess::WorkerProcess(ProcessOptions options, Callbacks callbacks)
    : options_(std::move(options)), callbacks_(std::move(callbacks)), thread_([this] { supervise(); }) {}

WorkerProcess::~WorkerProcess() {
    begin_stop(Clock::now());
    join();
}

bool WorkerProcess::send(const nlohmann::json& message) {
    std::shared_ptr<Link> link;
    {
        const std::lock_guard lock(mutex_);
        link = link_;
    }
    return link && link->channel.send(message);
}

void WorkerProcess::kill() { kill_because(ExitCause::Ordered, "killed by the daemon"); }

void WorkerProcess::kill_because(ExitCause cause, const std::string& text) {
    const std::lock_guard lock(mutex_);
    if (pid_ < 0) return;
    if (!killed_for_) {
        killed_for_ = cause;
        killed_text_ = text;
    }
    ::kill(pid_, SIGKILL);
}

void WorkerProcess::recycle() {
    {
        const std::lock_guard lock(mutex_);
        ordered_ = true;
    }
    send(message_json(StopMessage()));
}

void WorkerProcess::begin_stop(Clock::time_point deadline) {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
        ordered_ = true;
        stop_deadline_ = std::min(stop_deadline_, deadline);
    }
    changed_.notify_all();
    send(message_json(StopMessage()));
}

void WorkerProcess::join() {
    if (thread_.joinable()) thread_.join();
}

pid_t WorkerProcess::pid() const {
    const std::lock_guard lock(mutex_);
    return pid_;
}

std::optional<FileAccess> WorkerProcess::file_access() const {
    const std::lock_guard lock(mutex_);
    return file_access_;
}

void WorkerProcess::supervise() {
    milliseconds backoff{0};
    while (true) {
        {
            std::unique_lock lock(mutex_);
            changed_.wait_for(lock, backoff, [this] { return stopping_; });
            if (stopping_) return;
        }
        ProcessExit exit;
        if (const std::shared_ptr<Link> link = spawn()) {
            exit = attend(*link);
            {
                const std::lock_guard lock(mutex_);
                link_.reset();
            }
        } else {
            exit = {ExitCause::Lost, "could not be started", false};
        }
        resident_bytes_ = 0;
        if (exit.cause == ExitCause::Ordered)
            spdlog::info("worker {}: {}", options_.device, exit.text);
        else
            spdlog::warn("worker {}: {} ({})", options_.device, exit.text, exit_cause_name(exit.cause));
        callbacks_.exited(exit);
        // One that had been at work is replaced at once: what becomes of its job is limited by the job's attempts.
        if (exit.had_answered)
            backoff = milliseconds{0};
        else
            backoff = std::clamp(backoff * 2, kFirstBackoff, kLastBackoff);
    }
}

std::shared_ptr<WorkerProcess::Link> WorkerProcess::spawn() {
    try {
        const Child child = spawn_child(options_.program, worker_arguments(options_), options_.priority);
        auto link = std::make_shared<Link>(child.socket);
        const std::lock_guard lock(mutex_);
        pid_ = child.pid;
        link_ = link;
        file_access_.reset();
        ordered_ = stopping_;
        killed_for_.reset();
        return link;
    } catch (const std::exception& error) {
        spdlog::error("worker {}: {}", options_.device, error.what());
        return nullptr;
    }
}

ProcessExit WorkerProcess::attend(Link& link) {
    bool answered = false;
    const int times = options_.priority.background ? kBackgroundPatience : 1;
    const milliseconds silence = times * seconds_to_ms(options_.heartbeat_timeout_seconds);
    Clock::time_point last_heard = Clock::now();
    Clock::time_point last_look = last_heard;
    bool told_to_stop = false;
    while (!link.channel.closed()) {
        const auto message = link.channel.receive(static_cast<int>(kTick.count()));
        Clock::time_point now = Clock::now();
        if (message) {
            last_heard = now;
            if (!is_message<HeartbeatMessage>(*message) && take(*message))
                answered = answered || is_message<HelloMessage>(*message);
            now = Clock::now();
        }
        if (now - last_look < kTick) continue;
        last_look = now;
        callbacks_.tick();
        watch_memory();
        const milliseconds patience = answered ? silence : std::max<milliseconds>(silence, times * kLeastStartTime);
        if (now - last_heard > patience)
            kill_because(
                ExitCause::Hung,
                "no sign of life for " + std::to_string(duration_cast<milliseconds>(now - last_heard).count()) + " ms");
        Clock::time_point deadline;
        bool stopping = false;
        {
            const std::lock_guard lock(mutex_);
            deadline = stop_deadline_;
            stopping = stopping_;
        }
        // begin_stop() may have come while this child was being made.
        if (stopping && !told_to_stop) told_to_stop = link.channel.send(message_json(StopMessage()));
        if (now >= deadline) kill();
    }
    return reap(answered);
}

bool WorkerProcess::take(const nlohmann::json& message) {
    try {
        if (const auto hello = message_as<HelloMessage>(message)) {
            const std::lock_guard lock(mutex_);
            // Its first word is from before it has read what a stranger wrote.
            if (!file_access_) file_access_ = hello->file_access;
        }
        callbacks_.message(message);
        return true;
    } catch (const Error& error) {
        // A scene may have taken it over: what it says next is not to be trusted either.
        kill_because(ExitCause::Crashed, std::string("sent a message that cannot be read: ") + error.what());
        return false;
    }
}

void WorkerProcess::watch_memory() {
    const uint64_t resident = resident_bytes_of(pid_);  // only this thread changes pid_
    resident_bytes_ = resident;
    const uint64_t limit = options_.memory_limit_bytes;
    const uint64_t own = kOwnBytes + options_.driver_bytes;
    if (resident > own && resident - own > limit && resident - own - limit > limit / kIdleScenesDivisor)
        kill_because(ExitCause::OutOfMemory, "resident set of " + std::to_string(resident) +
                                                 " bytes, far above the limit of " + std::to_string(limit));
}

ProcessExit WorkerProcess::reap(bool had_answered) {
    // It has hung up, which a living process has no reason to do.
    if (const int handle = static_cast<int>(syscall(SYS_pidfd_open, pid_, 0)); handle >= 0) {
        pollfd ended{handle, POLLIN, 0};
        if (poll(&ended, 1, static_cast<int>(kLingering.count())) == 0)
            kill_because(ExitCause::Crashed, "closed its channel and went on");
        close(handle);
    } else {
        kill_because(ExitCause::Crashed, "closed its channel");
    }
    siginfo_t info{};
    while (waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOWAIT) != 0 && errno == EINTR) {
    }
    // The number may be another process's as soon as it is reaped, so nobody may kill() it from here on.
    const std::lock_guard lock(mutex_);
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    if (killed_for_ && WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL)
        return {*killed_for_, killed_text_, had_answered};
    if (WIFSIGNALED(status)) {
        const int signal = WTERMSIG(status);
        const std::string text =
            "killed by signal " + std::to_string(signal) + " (" + std::string(strsignal(signal)) + ")";
        if (signal == SIGXFSZ) return {ExitCause::NoSpace, text, had_answered};
        return {is_own_fault(signal) ? ExitCause::Crashed : ExitCause::Lost, text, had_answered};
    }
    const std::string text = "ended with status " + std::to_string(WEXITSTATUS(status));
    if (WEXITSTATUS(status) == kDeviceLostStatus)
        return {ExitCause::DeviceLost, "ended because its GPU stopped answering", had_answered};
    if (ordered_ && WEXITSTATUS(status) == 0) return {ExitCause::Ordered, text, had_answered};
    return {ExitCause::Crashed, text, had_answered};
}

}  // namespace photond
