#pragma once
// Runs the daemon's orders one after another and reports how each ended: the only catch for what a job throws.

#include <cstdlib>
#include <functional>
#include <nlohmann/json.hpp>

#include "protocol/worker_messages.h"
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

    /// Runs the order and sends StartedMessage, ProgressMessage, CurveMessage, FilmSavedMessage and, last,
    /// FinishedMessage or DeviceLostMessage.
    void run(const RenderMessage& order, JobControl& control) noexcept;

private:
    void render(const RenderMessage& message, JobControl& control, JobReport& report);

    SceneCache& scenes_;
    const Device device_;
    const unsigned max_threads_;
    const uint64_t memory_limit_bytes_;
    const Send send_;
    const std::function<void()> device_lost_;
};

}  // namespace photond
