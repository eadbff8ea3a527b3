#pragma once
// A method's parameters from the JSON of a request that has been read already.

#include <memory>
#include <nlohmann/json.hpp>

#include "protocol/param_json.h"
#include "renderer/methods/registry.h"

namespace photond {

/// What another version wrote and this one does not know is left out.
inline std::unique_ptr<MethodParams> params_of(const MethodInfo& method, const nlohmann::json& parameters) {
    std::unique_ptr<MethodParams> params = method.make_params();
    std::vector<Fault> faults;  // none of a request of now: the reader of jobs has seen to that
    read_params(*params, parameters, "/method/parameters", faults);
    return params;
}

/// MethodInfo::passes_stand_alone.
inline bool passes_stand_alone(const MethodInfo& method, const nlohmann::json& parameters) {
    return method.passes_stand_alone == nullptr || method.passes_stand_alone(*params_of(method, parameters));
}

/// MethodInfo::left_to_next.
inline std::vector<std::string_view> left_to_next(const MethodInfo& method, const nlohmann::json& parameters) {
    if (method.left_to_next == nullptr) return {};
    return method.left_to_next(*params_of(method, parameters));
}
/// What of a job with these parameters builds on what was before it, "passes" or "frames": its films cannot be joined
/// with others. Empty: nothing does.
inline std::string_view builds_on_before(const MethodInfo& method, const nlohmann::json& parameters) {
    if (!passes_stand_alone(method, parameters)) return "passes";
    return left_to_next(method, parameters).empty() ? "" : "frames";
}

/// MethodInfo::traces_on_host.
inline bool traces_on_host(const MethodInfo& method, const nlohmann::json& parameters) {
    return method.traces_on_host != nullptr && method.traces_on_host(*params_of(method, parameters));
}

}  // namespace photond
