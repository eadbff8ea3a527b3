#pragma once
// The closed error vocabulary: every failure that leaves the program is one of these rows. Standard library only, so
// that the renderer may throw them.

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace photond {

enum class ErrorCode : uint8_t {
    BadJson,
    WrongType,
    OutOfRange,
    MissingField,
    UnknownField,
    UnknownName,
    Conflict,
    Unsupported,
    BadScene,
    BadImage,
    NotFound,
    WrongState,
    WrongMediaType,
    NotAcceptable,
    MethodNotAllowed,
    BadRequest,
    PayloadTooLarge,
    HeadTooLarge,
    LengthRequired,
    RequestTimeout,
    RangeNotSatisfiable,
    Unauthorized,
    Forbidden,
    TooManyRequests,
    QueueFull,
    IdempotencyMismatch,
    DeviceUnavailable,
    OutOfMemory,
    NoSpace,
    TimedOut,
    WorkerCrashed,
    WorkerLost,
    DeviceLost,
    ResultLost,
    Cancelled,
    Unavailable,
    ResultDamaged,
    Internal,
};

struct ErrorKind {
    ErrorCode code;
    std::string_view name;  // the last part of the problem's `type`, and `failure.code` of a job
    int http_status;
    std::string_view meaning;  // the problem's `title`
};

// A row is a promise to clients; the API reference is printed from this table.
inline constexpr ErrorKind kErrorKinds[] = {
    {ErrorCode::BadJson, "bad_json", 400, "the body is not well-formed JSON"},
    {ErrorCode::WrongType, "wrong_type", 422, "the value has the wrong JSON type"},
    {ErrorCode::OutOfRange, "out_of_range", 422, "the value lies outside its declared range"},
    {ErrorCode::MissingField, "missing_field", 422, "a required field is missing"},
    {ErrorCode::UnknownField, "unknown_field", 422, "a field that is not declared"},
    {ErrorCode::UnknownName, "unknown_name", 422, "a name that does not exist here"},
    {ErrorCode::Conflict, "conflict", 422, "fields that exclude each other"},
    {ErrorCode::Unsupported, "unsupported", 422, "a feature this version does not have"},
    {ErrorCode::BadScene, "bad_scene", 422, "the scene cannot be loaded"},
    {ErrorCode::BadImage, "bad_image", 422, "the image cannot be read"},
    {ErrorCode::NotFound, "not_found", 404, "no such resource"},
    {ErrorCode::WrongState, "wrong_state", 409, "the resource is in a state that does not allow this"},
    {ErrorCode::WrongMediaType, "wrong_media_type", 415, "the content type or coding is not accepted here"},
    {ErrorCode::NotAcceptable, "not_acceptable", 406, "the resource has none of the types asked for"},
    {ErrorCode::MethodNotAllowed, "method_not_allowed", 405, "the resource does not have this method"},
    {ErrorCode::BadRequest, "bad_request", 400, "the HTTP request is malformed"},
    {ErrorCode::PayloadTooLarge, "payload_too_large", 413, "the body is larger than the limit"},
    {ErrorCode::HeadTooLarge, "head_too_large", 431, "the request's head is larger than the limit"},
    {ErrorCode::LengthRequired, "length_required", 411, "the request must state its Content-Length"},
    {ErrorCode::RequestTimeout, "request_timeout", 408, "the request did not arrive in time"},
    {ErrorCode::RangeNotSatisfiable, "range_not_satisfiable", 416, "the range lies outside the resource"},
    {ErrorCode::Unauthorized, "unauthorized", 401, "a valid bearer token is required"},
    {ErrorCode::Forbidden, "forbidden", 403, "the token, host or origin does not permit this"},
    {ErrorCode::TooManyRequests, "too_many_requests", 429, "too many requests"},
    {ErrorCode::QueueFull, "queue_full", 429, "the queue is full"},
    {ErrorCode::IdempotencyMismatch, "idempotency_mismatch", 422, "the idempotency key was used with another body"},
    {ErrorCode::DeviceUnavailable, "device_unavailable", 422, "this daemon has no such device"},
    {ErrorCode::OutOfMemory, "out_of_memory", 422, "the job needs more memory than it may use"},
    {ErrorCode::NoSpace, "no_space", 507, "the disk is full"},
    {ErrorCode::TimedOut, "timed_out", 500, "the job passed its deadline"},
    {ErrorCode::WorkerCrashed, "worker_crashed", 500, "the worker process crashed on this job"},
    {ErrorCode::WorkerLost, "worker_lost", 500, "the worker process was lost more often than is retried"},
    {ErrorCode::DeviceLost, "device_lost", 500, "the GPU stopped answering on this job"},
    {ErrorCode::ResultLost, "result_lost", 500,
     "the files of the job's result are gone: submit its request again, or restore a backup"},
    {ErrorCode::Cancelled, "cancelled", 409, "the job was cancelled"},
    {ErrorCode::Unavailable, "unavailable", 503, "not now: ask again later"},
    {ErrorCode::ResultDamaged, "result_damaged", 500,
     "what was kept of a job is damaged: submit its request again, or restore a backup"},
    {ErrorCode::Internal, "internal", 500, "a defect in the service"},
};

constexpr const ErrorKind& error_kind(ErrorCode code) { return kErrorKinds[static_cast<size_t>(code)]; }

/// The code with this wire name; Internal where there is none.
constexpr ErrorCode error_code_named(std::string_view name) {
    for (const ErrorKind& kind : kErrorKinds)
        if (kind.name == name) return kind.code;
    return ErrorCode::Internal;
}

/// One fault, of which kind it is, and the place it is at: a JSON pointer (RFC 6901) into the body or the glTF, empty
/// for the whole.
struct Fault {
    Fault(ErrorCode kind, std::string place, std::string what)
        : code(kind), pointer(std::move(place)), detail(std::move(what)) {}

    ErrorCode code;
    std::string pointer;
    std::string detail;
};

/// Bad input or a missing resource: what went wrong, where, with the value and the limit in the message.
class Error : public std::runtime_error {
public:
    Error(ErrorCode error_code, std::string pointer, const std::string& detail)
        : std::runtime_error(detail), code(error_code), faults{{error_code, std::move(pointer), detail}} {}
    Error(ErrorCode error_code, const std::string& detail) : std::runtime_error(detail), code(error_code) {}
    Error(ErrorCode error_code, const std::string& detail, std::vector<Fault> all)
        : std::runtime_error(detail), code(error_code), faults(std::move(all)) {}

    const ErrorCode code;
    const std::vector<Fault> faults;  // all faults found, each with its place; may be empty
};

consteval bool error_kinds_are_in_order() {
    for (size_t i = 0; i < std::size(kErrorKinds); ++i)
        if (static_cast<size_t>(kErrorKinds[i].code) != i) return false;
    return static_cast<size_t>(ErrorCode::Internal) + 1 == std::size(kErrorKinds);
}
static_assert(error_kinds_are_in_order(), "error_kind() indexes the table by code");

}  // namespace photond
