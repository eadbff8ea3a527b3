#include "server/service/processes.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <utility>

#include "renderer/scene/builtin_scenes.h"

namespace photond {

namespace {

constexpr std::chrono::seconds kPrewarmDelay{5};

}  // namespace

Processes::~Processes() {
    std::unique_ptr<Helper> helper, bulk_helper;  // end without the lock, which their callbacks take
    const std::lock_guard lock(core_.mutex);
    helper = std::move(core_.helper);
    bulk_helper = std::move(core_.bulk_helper);
}

void Processes::start() {
    ProcessOptions process = core_.process_options();
    const auto helper_exited = [this](const ProcessExit& exit) {
        attempts_.update_ready();
        if (exit.cause != ExitCause::Ordered) core_.metrics.worker_restarted(std::string(exit_cause_name(exit.cause)));
    };
    // Callbacks come from threads that start here; they take the lock, and so see what is built below whole.
    const std::lock_guard lock(core_.mutex);
    process.reads = {core_.files.scenes, core_.files.images, core_.files.films};
    process.writes = {core_.files.spool, core_.files.cache};
    process.device = "none";
    process.priority.nice = std::max(0, core_.options.worker_nice - 2);  // people wait for it
    const auto make_helper = [&] {
        return std::make_unique<Helper>(
            process, core_.options.limits.helper_timeout_seconds, [this] { attempts_.update_ready(); }, helper_exited);
    };
    process.more_arguments = {"--warm-up"};  // 0.15 s of a processor, which the others take when they are needed
    core_.helper = make_helper();
    process.more_arguments.clear();
    core_.bulk_helper = make_helper();
    pictures_.start(process, helper_exited);
    process.priority.nice = core_.options.worker_nice;
    process.threads = core_.options.threads;
    process.writes = {core_.files.films};
    attempts_.start(process);
    prewarm_ = std::thread([this] { prewarm(); });
}

void Processes::prewarm() {
    // Half a second of processor time, which a job would miss.
    std::unique_lock lock(core_.mutex);
    if (core_.attempt_changed.wait_for(lock, kPrewarmDelay, [this] { return core_.stopping; })) return;
    try {
        for (const std::string_view name : builtin_scene_names()) {
            core_.attempt_changed.wait(lock, [this] { return core_.stopping || core_.jobs_on_host_cores == 0; });
            if (core_.stopping) return;
            lock.unlock();
            scenes_.builtin_object(std::string(name));
            lock.lock();
        }
    } catch (const std::exception& error) {
        spdlog::warn("built-in scenes are judged later: {}", error.what());  // when somebody asks for one
    }
}

void Processes::stop() {
    std::call_once(stopped_, [this] {
        const auto grace =
            std::chrono::milliseconds(static_cast<int64_t>(core_.options.limits.shutdown_grace_seconds * 1000));
        // The rest of the grace time is for what comes after the workers.
        const auto deadline = SteadyClock::now() + grace * 3 / 4;
        {
            const std::lock_guard lock(core_.mutex);
            core_.stopping = true;
            core_.ready = false;
            attempts_.begin_stop(deadline);
        }
        core_.attempt_changed.notify_all();
        if (core_.helper) core_.helper->begin_stop(deadline);
        if (core_.bulk_helper) core_.bulk_helper->begin_stop(deadline);
        pictures_.begin_stop(deadline);
        attempts_.join();
        if (core_.helper) core_.helper->join();
        if (core_.bulk_helper) core_.bulk_helper->join();
        pictures_.join();
        if (prewarm_.joinable()) prewarm_.join();
        spdlog::info("all processes have ended");
    });
}

}  // namespace photond
