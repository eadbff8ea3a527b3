#pragma once
// The one list of methods. Only methods that work are in it.

#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "renderer/methods/method.h"

namespace photond {

struct MethodInfo {
    std::string_view name;  // folder, `method.name`, row in every table
    std::string_view title;
    std::string_view family;
    std::vector<std::string_view> sources;
    bool mergeable = true;
    bool deterministic_cpu = true;          // same pixel hash for any number of threads
    std::vector<std::string_view> devices;  // kinds: "cpu", "gpu"
    std::unique_ptr<MethodParams> (*make_params)();
    std::unique_ptr<Method> (*make)(const MethodParams& params);
    /// Bytes the method itself will record in its budget: all but the film, the scene and its ray structure.
    uint64_t (*estimate_bytes)(const MethodParams& params, const Workload& workload);
};

std::span<const MethodInfo> all_methods();  // by name
/// nullptr when there is none of that name.
const MethodInfo* find_method(std::string_view name);

}  // namespace photond
