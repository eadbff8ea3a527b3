#pragma once
// An Error as RFC 9457 problem details: the one shape in which failures leave the service.

#include <nlohmann/json.hpp>
#include <string>

#include "protocol/error.h"

namespace photond {

inline constexpr const char* kProblemMediaType = "application/problem+json";

/// {"type", "title", "status", "code", "detail", "instance", "errors": [{"pointer", "detail"}]}; `instance` is null
/// where it does not apply. Text that is not UTF-8 is replaced, so that the document can always be written.
nlohmann::json problem_json(ErrorCode code, const std::string& detail, const std::vector<Fault>& faults,
                            const std::string& instance = "");
nlohmann::json problem_json(const Error& error, const std::string& instance = "");

/// The text with every byte that is not UTF-8 replaced by U+FFFD.
std::string as_utf8(const std::string& text);

}  // namespace photond
