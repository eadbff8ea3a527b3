#include "protocol/message_parts.h"

#include <utility>

namespace photond {

Failure Failure::of(const Error& error) {
    Failure failure{std::string(error_kind(error.code).name), error.what(), {}};
    for (const Fault& fault : error.faults)
        failure.errors.push_back({std::string(error_kind(fault.code).name), fault.pointer, fault.detail});
    return failure;
}

Error error_of(const std::optional<Failure>& failure) {
    if (!failure) return Error(ErrorCode::Internal, "the worker gave no reason");
    std::vector<Fault> faults;
    for (const Failure::Place& place : failure->errors)
        faults.emplace_back(error_code_named(place.code), place.pointer, place.detail);
    return Error(error_code_named(failure->code), failure->detail, std::move(faults));
}

}  // namespace photond
