#include "server/worker/worker_loop.h"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <memory>
#include <thread>
#include <utility>

#include "protocol/error.h"
#include "protocol/worker_messages.h"
#include "renderer/core/parallel.h"
#include "renderer/film/exr_file.h"
#include "server/worker/helper_tasks.h"
#include "server/worker/job_runner.h"
#include "server/worker/process_memory.h"

namespace photond {

using nlohmann::json;

namespace {

constexpr std::chrono::seconds kHeartbeat{1};
/// Share of the memory limit that scenes of other jobs may keep while they are not used; on top of what the job may
/// hold.
constexpr uint64_t kIdleScenesDivisor = 8;
constexpr int kSettledMilliseconds = 1'000;  // without a request; then the helper loads the image library for the first
constexpr int kWarmMilliseconds =
    120'000;  // without a request; then the helper lets go of its warm scene and its memory

/// Sends a heartbeat each second, from a thread that nothing a render does can delay.
class Heartbeat {
public:
    explicit Heartbeat(MessageChannel& channel)
        : thread_([this, &channel] {
              std::unique_lock lock(mutex_);
              while (!wake_.wait_for(lock, kHeartbeat, [this] { return ended_; }))
                  channel.send(message_json(HeartbeatMessage{resident_bytes()}));
          }) {}
    ~Heartbeat() {
        {
            const std::lock_guard lock(mutex_);
            ended_ = true;
        }
        wake_.notify_one();
        thread_.join();
    }

private:
    std::mutex mutex_;
    std::condition_variable wake_;
    bool ended_ = false;
    std::thread thread_;
};

void say_hello(MessageChannel& channel, const WorkerOptions& options) {
    channel.send(message_json(HelloMessage{getpid(), options.device.to_json(), options.file_access}));
}

/// Starts what the first job would otherwise pay for and be charged with: TBB's threads and their stacks.
void start_threads() {
    std::atomic<uint64_t> sum{0};
    parallel_for(1 << 14, 1, [&](size_t i) { sum += i; });
}

/// The job that is running, if any, in a thread of its own.
class RunningJob {
public:
    bool running() const { return thread_.joinable() && !*over_; }
    bool is(const std::string& job) const { return running() && job == job_; }

    void start(JobRunner& runner, const RenderMessage& order) {
        wait();
        job_ = order.job;
        control_ = std::make_shared<JobControl>();
        over_ = std::make_shared<std::atomic<bool>>(false);
        thread_ = std::thread([&runner, order, control = control_, over = over_] {
            runner.run(order, *control);
            *over = true;
        });
    }
    JobControl& control() { return *control_; }
    void wait() {
        if (thread_.joinable()) thread_.join();
    }

private:
    std::string job_;
    std::shared_ptr<JobControl> control_;
    std::shared_ptr<std::atomic<bool>> over_;
    std::thread thread_;
};

/// The GPU is lost, and with it this process' way to it. The daemon starts another.
[[noreturn]] void end_without_gpu() { std::_Exit(kDeviceLostStatus); }

/// What the daemon says. One that is of another version cannot be followed, whatever this process is at.
std::optional<DaemonMessage> read_from_daemon(const json& message) {
    try {
        return read_daemon_message(message);
    } catch (const Error& error) {
        spdlog::critical("a message of the daemon cannot be read: {}", error.what());
        std::_Exit(1);
    }
}

/// Loads the image library. A helper without it still answers: an image is refused by the same error.
void warm_up_images() {
    try {
        warm_up_exr();
    } catch (const Error& error) {
        spdlog::error("{}", error.what());
    }
}

}  // namespace

int run_render_worker(MessageChannel& channel, const WorkerOptions& options) {
    start_threads();
    SceneCache scenes(options.memory_limit_bytes / kIdleScenesDivisor, options.device.in_use.get());
    JobRunner runner(
        scenes, options.device, options.threads, options.memory_limit_bytes,
        [&channel](const json& message) { channel.send(message); }, end_without_gpu);
    RunningJob job;
    say_hello(channel, options);
    const Heartbeat heartbeat(channel);
    while (const std::optional<json> message = channel.receive(-1)) {
        const std::optional<DaemonMessage> told = read_from_daemon(*message);
        if (!told) {
            spdlog::error("a message of unknown type \"{}\"", type_of_message(*message));
        } else if (const auto* order = std::get_if<RenderMessage>(&*told)) {
            // FinishedMessage is sent just before a job's thread ends; the daemon may be quicker than that.
            job.wait();
            job.start(runner, *order);
        } else if (const auto* snapshot = std::get_if<SnapshotMessage>(&*told)) {
            if (job.is(snapshot->job)) job.control().film_so_far.ask(snapshot->path);
        } else if (const auto* cancel = std::get_if<CancelMessage>(&*told)) {
            if (job.is(cancel->job)) job.control().cancel.cancel();
        } else {  // StopMessage
            if (job.running()) {
                job.control().stopping = true;
                job.control().cancel.cancel();
            }
            job.wait();
            return 0;
        }
    }
    // The daemon is gone: nobody waits for the result, and a pass may take long.
    std::_Exit(0);
}

int list_devices(MessageChannel& channel) {
    DevicesMessage devices;
    for (const Device& device : all_devices()) devices.items.push_back(device.to_json());
    return channel.send(message_json(std::move(devices))) ? 0 : 1;
}

int run_helper(MessageChannel& channel, const WorkerOptions& options) {
    keep_free_memory(kHelperKeptBytes);
    start_threads();
    say_hello(channel, options);
    const Heartbeat heartbeat(channel);
    SceneCache scenes(0);
    bool warm = !options.warm_up, holds_memory = false;
    while (true) {
        const std::optional<json> message = channel.receive(!warm          ? kSettledMilliseconds
                                                            : holds_memory ? kWarmMilliseconds
                                                                           : -1);
        if (!message) {
            if (channel.closed()) std::_Exit(0);
            if (!std::exchange(warm, true)) {
                warm_up_images();
                continue;
            }
            scenes.clear();  // nobody turns it any more
            release_free_memory();
            holds_memory = false;
            continue;
        }
        if (is_message<StopMessage>(*message)) return 0;
        warm = holds_memory = true;
        channel.send(run_helper_task(*message, {options.memory_limit_bytes, options.threads}, scenes));
    }
}

}  // namespace photond
