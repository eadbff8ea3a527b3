#include "server/service/page_cursor.h"

#include <charconv>

#include "protocol/error.h"

namespace photond {

void check_limit(uint32_t limit) {
    if (limit < 1 || limit > 1000)
        throw Error(ErrorCode::OutOfRange, "/limit", "limit = " + std::to_string(limit) + " is outside [1, 1000]");
}

int64_t read_cursor(const std::string& cursor, int64_t otherwise) {
    if (cursor.empty()) return otherwise;
    int64_t value = 0;
    const auto [end, error] = std::from_chars(cursor.data(), cursor.data() + cursor.size(), value);
    if (error != std::errc() || end != cursor.data() + cursor.size() || value < 0)
        throw Error(ErrorCode::OutOfRange, "/cursor", "'" + cursor + "' is no cursor of this list");
    return value;
}

}  // namespace photond
