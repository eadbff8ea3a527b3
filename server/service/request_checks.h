#pragma once
// A request judged by all that this daemon knows: its devices, scenes, images, jobs and limits.

#include <string>

#include "protocol/job.h"
#include "server/service/estimates.h"
#include "server/service/scenes.h"
#include "server/service/service_core.h"

namespace photond {

/// All under the lock. What they throw has its place in the request.
class RequestChecks {
public:
    RequestChecks(ServiceCore& core, Scenes& scenes, Estimates& estimates)
        : core_(core), scenes_(scenes), estimates_(estimates) {}

    /// Everything of a request that depends on this daemon; the scene it means. Throws UnknownName, Conflict,
    /// OutOfRange, Unsupported, DeviceUnavailable, OutOfMemory.
    SceneRef check_request(const JobRequest& request);

private:
    /// Throws Unsupported for parameters that only the CPU has, where the method is to run on a GPU; faults at
    /// prefix + "/method/parameters/...".
    static void check_parameters(const JobMethod& method, const std::string& prefix);
    /// Pixels and memory, at `pointer`.
    void check_size(const JobRequest& request, const SceneRef& scene, const std::string& pointer);
    void check_device_memory(const JobRequest& request, const SceneRef& scene, const std::string& pointer);
    /// Faults of request.reference and of the layers its metrics need.
    void check_reference(const JobRequest& request, const SceneRef& scene);

    ServiceCore& core_;
    Scenes& scenes_;
    Estimates& estimates_;
};

}  // namespace photond
