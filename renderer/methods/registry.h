#pragma once
// The one list of methods. Only methods that work are in it.

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/frame/method.h"

namespace photond {

/// A file a method can leave beside the image (MethodArtefact), served as /v1/jobs/ID/NAME.
struct ArtefactInfo {
    std::string_view name;  // "photon_map.glb"; its link in a job is the part before the dot
    std::string_view media_type;
    std::string_view parameter;  // the flag of the method that asks for it
    std::string_view text;       // what it is: "photon map"
};

struct MethodInfo {
    std::string_view name;  // folder, `method.name`, row in every table
    std::string_view title;
    std::string_view family;
    std::vector<std::string_view> sources;
    bool mergeable = true;
    bool deterministic_cpu = true;          // same pixel hash for any number of threads
    bool deterministic_gpu = true;          // same pixel hash on one device and driver
    std::vector<std::string_view> devices;  // kinds: "cpu", "gpu"
    LayerSet layers;                        // those it can fill
    std::vector<ArtefactInfo> artefacts;
    std::unique_ptr<MethodParams> (*make_params)();
    std::unique_ptr<Method> (*make)(const MethodParams& params);      // for the CPU; null where `devices` has no "cpu"
    std::unique_ptr<Method> (*make_gpu)(const MethodParams& params);  // null where `devices` has no "gpu"
    /// Bytes the method itself will record in its budget: all but the film, the scene and its ray structure. Null where
    /// there is no make.
    uint64_t (*estimate_bytes)(const MethodParams& params, const Workload& workload);
    /// Likewise on a GPU: of the host's memory; null where there is no make_gpu.
    uint64_t (*estimate_bytes_gpu)(const MethodParams& params, const Workload& workload);
    /// Throws ErrorCode::Unsupported, with a pointer to the parameter, for what only the CPU has.
    void (*check_gpu)(const MethodParams& params);
    /// Bytes of the GPU's memory the method will take beside the scene's; null where there is no make_gpu.
    uint64_t (*estimate_device_bytes)(const MethodParams& params, const Workload& workload);
    /// About the bytes of the artefacts it will leave on the disk.
    uint64_t (*estimate_artefact_bytes)(const MethodParams& params, const Workload& workload);

    /// nullptr when it has no artefact of that name.
    const ArtefactInfo* find_artefact(std::string_view artefact_name) const;
    /// Names of the layers that a job has to ask for, those of them it can fill; in the order of kLayers.
    std::vector<std::string> layers_on_request() const;
};

std::span<const MethodInfo> all_methods();  // by name
/// nullptr when there is none of that name.
const MethodInfo* find_method(std::string_view name);
/// Of all methods, each name once.
std::span<const ArtefactInfo> all_artefacts();

}  // namespace photond
