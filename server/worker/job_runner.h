#pragma once
// Scene -> method -> film -> result. The job runner owns the pass loop, the stop conditions, progress, snapshots,
// cancellation and statistics, and the only catch.

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "protocol/job.h"
#include "renderer/core/cancel.h"
#include "renderer/methods/registry.h"
#include "server/worker/device.h"
#include "server/worker/scene_cache.h"

namespace photond {

/// What other threads may ask of a running job.
class JobControl {
public:
    CancelToken cancel;
    std::atomic<bool> stopping{false};  // cancelled because the worker is to end

    /// Save the film so far to `path` after the pass at hand; a second request before that replaces the first.
    void request_snapshot(std::filesystem::path path);
    std::optional<std::filesystem::path> take_snapshot();

private:
    std::mutex mutex_;
    std::optional<std::filesystem::path> snapshot_;
};

/// Begins a method and runs passes until a stop condition is met or `cancel` is seen. The film's memory and the
/// method's are required of the budget first. `after_pass` is called after each finished pass, off the clock.
struct PassLoop {
    Method& method;
    const RenderContext& context;
    StopConditions stop;
    const CancelToken& cancel;
    std::function<void(const Film& film, double render_seconds)> after_pass;

    struct Result {
        Film film;
        double render_seconds = 0;  // begin + passes + resolve, nothing else
        bool cancelled = false;
    };
    Result run(Stats& stats);
};

/// The method a request asks for, its parameters checked. Throws photond::Error with every fault's pointer.
std::unique_ptr<Method> make_method(const JobRequest& request);

/// The view a request asks for, its camera found in the scene. Throws photond::Error with pointers into the request.
View resolve_view(const JobRequest& request, const Scene& scene);

class JobRunner {
public:
    using Send = std::function<void(const nlohmann::json& message)>;

    JobRunner(SceneCache& scenes, Device device, unsigned max_threads, uint64_t memory_limit_bytes, Send send);

    /// Runs a "render" order (worker_messages.h) and sends started, progress, film_saved and, last, finished.
    void run(const nlohmann::json& order, JobControl& control) noexcept;

private:
    struct Report;
    void render(const nlohmann::json& order, JobControl& control, Report& report);
    static void save_artefacts(const Method& method, const std::filesystem::path& film_path, Report& report);

    SceneCache& scenes_;
    const Device device_;
    const unsigned max_threads_;
    const uint64_t memory_limit_bytes_;
    const Send send_;
};

}  // namespace photond
