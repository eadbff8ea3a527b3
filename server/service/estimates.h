#pragma once
// What a job will take, before it is queued.

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "protocol/job.h"
#include "renderer/frame/left_out.h"
#include "renderer/frame/render_context.h"
#include "server/service/scenes.h"
#include "server/service/service_core.h"

namespace photond {

/// Of a job that succeeded, what tells how long another will take.
struct EarlierJob {
    std::string scene;
    nlohmann::json parameters;
    double pixels = 0, seconds = 0, passes = 0;
    double photon_seconds = 0;  // of its seconds, those that its photons took
};
/// By method and device; read from the store once for all that is estimated together.
using EarlierJobs = std::map<std::pair<std::string, std::string>, std::vector<EarlierJob>>;

/// How long rendering will take. Nothing is known of a pass where the method has rendered none here.
struct TimeEstimate {
    std::optional<double> seconds;       // known also where the job stops by them
    std::optional<double> pass_seconds;  // of one pass
    std::string warning;                 // of seconds that cannot be kept; empty: none
};

/// All are called under the lock.
class Estimates {
public:
    Estimates(ServiceCore& core, Scenes& scenes) : core_(core), scenes_(scenes) {}

    /// Throws DeviceUnavailable.
    TimeEstimate estimate_time(const JobRequest& request, const SceneRef& scene, EarlierJobs& earlier);
    /// What the worker's budget will hold, to a few percent.
    uint64_t estimate_memory_bytes(const JobRequest& request, const SceneRef& scene);
    /// What it will take of a GPU's memory, its scene included; nothing on the CPU.
    std::optional<uint64_t> estimate_device_bytes(const JobRequest& request, const SceneRef& scene);
    /// Kinds of path that it will not show.
    PathsLeftOut paths_left_out(const JobRequest& request, const SceneRef& scene);
    /// What a job will leave on the disk.
    uint64_t estimate_disk_bytes(const JobRequest& request, const SceneRef& scene);

private:
    std::optional<double> estimate_pass_seconds(const JobRequest& request, const SceneRef& scene, EarlierJobs& earlier);
    Workload workload_of(const JobRequest& request, const nlohmann::json& summary);

    ServiceCore& core_;
    Scenes& scenes_;
};

}  // namespace photond
