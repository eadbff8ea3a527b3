#pragma once
#include <cstdint>
#include <string>

namespace photond {

/// Milliseconds since 1970 UTC.
int64_t now_ms();
/// RFC 3339, UTC, with milliseconds.
std::string rfc3339(int64_t ms);

}  // namespace photond
