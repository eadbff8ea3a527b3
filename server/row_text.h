#pragma once
// Rows of the store as JSON: what is empty or absent there is null here.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "server/clock_text.h"

namespace photond {

/// Null for empty text; else the text is JSON that the service itself wrote.
inline nlohmann::json parsed_or_null(const std::string& text) {
    return text.empty() ? nlohmann::json() : nlohmann::json::parse(text);
}

/// Text of a row's JSON member; empty for null and for what holds nothing.
inline std::string text_of(const nlohmann::json& value) {
    return value.empty() ? "" : value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// RFC 3339, or null.
inline nlohmann::json time_or_null(const std::optional<int64_t>& ms) {
    return ms ? nlohmann::json(rfc3339(*ms)) : nlohmann::json();
}

}  // namespace photond
