#pragma once
// What every list is asked for: how many items, and from where.

#include <cstdint>
#include <string>

namespace photond {

/// A page's limit. Throws OutOfRange outside 1..1000.
void check_limit(uint32_t limit);
/// A cursor that is a number; `otherwise` when it is empty. Throws OutOfRange.
int64_t read_cursor(const std::string& cursor, int64_t otherwise);

}  // namespace photond
