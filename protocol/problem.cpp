#include "protocol/problem.h"

namespace photond {

using nlohmann::json;

std::string as_utf8(const std::string& text) {
    const std::string quoted = json(text).dump(-1, ' ', false, json::error_handler_t::replace);
    return json::parse(quoted).get<std::string>();
}

json problem_json(ErrorCode code, const std::string& detail, const std::vector<Fault>& faults,
                  const std::string& instance) {
    const ErrorKind& kind = error_kind(code);
    json errors = json::array();
    for (const Fault& fault : faults)
        errors.push_back({{"code", error_kind(fault.code).name},
                          {"pointer", as_utf8(fault.pointer)},
                          {"detail", as_utf8(fault.detail)}});
    return {{"type", "urn:photond:problem:" + std::string(kind.name)},
            {"title", kind.meaning},
            {"status", kind.http_status},
            {"code", kind.name},
            {"detail", as_utf8(detail)},
            {"instance", instance.empty() ? json(nullptr) : json(as_utf8(instance))},
            {"errors", errors}};
}

json problem_json(const Error& error, const std::string& instance) {
    return problem_json(error.code, error.what(), error.faults, instance);
}

}  // namespace photond
