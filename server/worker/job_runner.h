#pragma once
// Runs the daemon's orders one after another and reports how each ended: the only catch for what a job throws.

#include <cstdlib>
#include <functional>
#include <nlohmann/json.hpp>

#include "server/worker/device.h"
#include "server/worker/job_setup.h"
#include "server/worker/pass_loop.h"
#include "server/worker/render_job.h"
#include "server/worker/scene_cache.h"

namespace photond {

class JobRunner {
public:
    using Send = std::function<void(const nlohmann::json& message)>;

    /// `device_lost` is called once that has been sent and must not return: nothing can be done with the device.
    JobRunner(
        SceneCache& scenes, Device device, unsigned max_threads, uint64_t memory_limit_bytes, Send send,
        std::function<void()> device_lost = [] { std::abort(); });

    /// Runs a "render" order (worker_messages.h) and sends started, progress, curve, film_saved and, last, finished or
    /// device_lost.
    void run(const nlohmann::json& order, JobControl& control) noexcept;

private:
    void render(const nlohmann::json& message, JobControl& control, JobReport& report);

    SceneCache& scenes_;
    const Device device_;
    const unsigned max_threads_;
    const uint64_t memory_limit_bytes_;
    const Send send_;
    const std::function<void()> device_lost_;
};

}  // namespace photond
