#include "server/worker/job_runner.h"

#include <spdlog/spdlog.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "protocol/worker_messages.h"
#include "renderer/backends/gpu/device.h"
#include "server/worker/process_memory.h"

namespace photond {

using nlohmann::json;

JobRunner::JobRunner(SceneCache& scenes, Device device, unsigned max_threads, uint64_t memory_limit_bytes, Send send,
                     std::function<void()> device_lost)
    : scenes_(scenes),
      device_(std::move(device)),
      max_threads_(max_threads),
      memory_limit_bytes_(memory_limit_bytes),
      send_(std::move(send)),
      device_lost_(std::move(device_lost)) {}

void JobRunner::run(const json& order, JobControl& control) noexcept {
    JobReport report;
    const auto fail = [&](json failure) {
        report.state = "failed";
        report.log.push_back("failed: " + failure["detail"].get<std::string>());
        report.failure = std::move(failure);
        report.film = nullptr;
        report.artefacts = json::array();
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
        spdlog::error("job {}: {}", order.value("job", json(nullptr)).dump(), lost.what());
        send_({{"type", "device_lost"},
               {"job", order.value("job", json(nullptr))},
               {"attempt", order.value("attempt", json(nullptr))},
               {"reason", lost.what()}});
        device_lost_();
    } catch (const Error& error) {
        fail(failure_json(error));
    } catch (const std::bad_alloc&) {
        fail(failure_json(ErrorCode::OutOfMemory, "ran out of memory under the worker's limit of " +
                                                      std::to_string(memory_limit_bytes_) +
                                                      " bytes; lower the image size or the method's parameters"));
    } catch (const std::exception& defect) {
        spdlog::error("job {}: {}", order.value("job", json(nullptr)).dump(), defect.what());
        fail(failure_json(ErrorCode::Internal, "internal error, written to the log under this job's id"));
    }
    send_({{"type", "finished"},
           {"job", order.value("job", json(nullptr))},
           {"attempt", order.value("attempt", json(nullptr))},
           {"state", report.state},
           {"passes_done", report.passes_done},
           {"seconds", report.seconds},
           {"film", report.film},
           {"statistics", report.statistics},
           {"rendered", report.rendered},
           {"curve", report.curve},
           {"error_now", report.error_now},
           {"artefacts", report.artefacts},
           {"failure", report.failure},
           {"log", report.log},
           {"stopping", control.stopping.load()}});
    release_free_memory();  // off everybody's clock, and before the next job's baseline is taken
}

void JobRunner::render(const json& message, JobControl& control, JobReport& report) {
    send_({{"type", "started"}, {"job", message.at("job")}, {"attempt", message.value("attempt", json(nullptr))}});
    const RenderOrder order = RenderOrder::from_json(message, memory_limit_bytes_, max_threads_);
    const tbb::global_control bound(tbb::global_control::max_allowed_parallelism, order.threads);
    tbb::task_arena arena(static_cast<int>(order.threads));
    arena.execute([&] { RenderJob(order, control, scenes_, device_, report, send_).run(); });
}

}  // namespace photond
