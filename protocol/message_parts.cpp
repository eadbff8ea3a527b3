#include "protocol/message_parts.h"

#include <utility>

namespace photond {

Failure Failure::of(const Error& error) {
    Failure failure{std::string(error_kind(error.code).name), error.what(), {}};
    for (const Fault& fault : error.faults) failure.errors.push_back({fault.pointer, fault.detail});
    return failure;
}

Error error_of(const std::optional<Failure>& failure) {
    if (!failure) return Error(ErrorCode::Internal, "the worker gave no reason");
    std::vector<Fault> faults;
    for (const Failure::Place& place : failure->errors) faults.push_back({place.pointer, place.detail});
    return Error(error_code_named(failure->code), failure->detail, std::move(faults));
}

}  // namespace photond
