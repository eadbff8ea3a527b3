#include "server/worker/job_runner.h"

#include <spdlog/spdlog.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "renderer/backends/gpu/device.h"
#include "server/worker/process_memory.h"

namespace photond {

JobRunner::JobRunner(SceneCache& scenes, Device device, unsigned max_threads, uint64_t memory_limit_bytes, Send send,
                     std::function<void()> device_lost)
    : scenes_(scenes),
      device_(std::move(device)),
      max_threads_(max_threads),
      memory_limit_bytes_(memory_limit_bytes),
      send_(std::move(send)),
      device_lost_(std::move(device_lost)) {}

void JobRunner::run(const RenderMessage& order, JobControl& control) noexcept {
    JobReport report;
    report.job = order.job, report.attempt = order.attempt;
    const auto fail = [&](const Error& error) {
        report.state = "failed";
        report.log.push_back(std::string("failed: ") + error.what());
        report.failure = Failure::of(error);
        report.film.reset();
        report.artefacts.clear();
        for (const std::filesystem::path& file : report.artefact_files) {
            std::error_code gone_already;
            std::filesystem::remove(file, gone_already);
        }
    };
    // Code below this function throws; it catches only where a job can do without what failed.
    try {
        render(order, control, report);
        // Compiled pipelines outlive a worker that is killed.
        if (device_.in_use) device_.in_use->save_pipeline_cache();
    } catch (const gpu::DeviceLost& lost) {
        spdlog::error("job {}: {}", order.job, lost.what());
        send_(message_json(DeviceLostMessage{order.job, order.attempt, lost.what()}));
        device_lost_();
    } catch (const Error& error) {
        fail(error);
    } catch (const std::bad_alloc&) {
        fail(Error(ErrorCode::OutOfMemory, "ran out of memory under the worker's limit of " +
                                               std::to_string(memory_limit_bytes_) +
                                               " bytes; lower the image size or the method's parameters"));
    } catch (const std::exception& defect) {
        spdlog::error("job {}: {}", order.job, defect.what());
        fail(Error(ErrorCode::Internal, "internal error, written to the log under this job's id"));
    }
    report.stopping = control.stopping;
    send_(message_json<FinishedMessage>(std::move(report)));
    release_free_memory();  // off everybody's clock, and before the next job's baseline is taken
}

void JobRunner::render(const RenderMessage& message, JobControl& control, JobReport& report) {
    send_(message_json(StartedMessage{message.job, message.attempt}));
    const RenderOrder order = RenderOrder::of(message, memory_limit_bytes_, max_threads_);
    const tbb::global_control bound(tbb::global_control::max_allowed_parallelism, order.threads);
    tbb::task_arena arena(static_cast<int>(order.threads));
    arena.execute([&] { RenderJob(order, control, scenes_, device_, report, send_).run(); });
}

}  // namespace photond
