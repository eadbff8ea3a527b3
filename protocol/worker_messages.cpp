#include "protocol/worker_messages.h"

namespace photond {

using nlohmann::json;

json failure_json(ErrorCode code, const std::string& detail, const std::vector<Fault>& faults) {
    json errors = json::array();
    for (const Fault& fault : faults) errors.push_back({{"pointer", fault.pointer}, {"detail", fault.detail}});
    return {{"code", error_kind(code).name}, {"detail", detail}, {"errors", errors}};
}

json failure_json(const Error& error) { return failure_json(error.code, error.what(), error.faults); }

}  // namespace photond
