#pragma once
// Rows of the store as JSON: what is empty or absent there is null here.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "server/clock_text.h"
#include "server/store/store.h"

namespace photond {

/// Null for empty text; else the text is JSON that the service itself wrote.
inline nlohmann::json parsed_or_null(const std::string& text) {
    return text.empty() ? nlohmann::json() : nlohmann::json::parse(text);
}

/// Text of a row's JSON member; empty for null and for what holds nothing.
inline std::string text_of(const nlohmann::json& value) {
    return value.empty() ? "" : value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// An object put together from texts that are JSON already: a row's long members are not read only to be written again.
class ObjectText {
public:
    ObjectText& add(std::string_view name, const nlohmann::json& value) {
        return add_text(name, value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    }
    /// `text` is JSON; null where it is empty.
    ObjectText& add_text(std::string_view name, std::string_view text) {
        text_ += text_.empty() ? "{\"" : ",\"";
        text_.append(name).append("\":").append(text.empty() ? "null" : text);
        return *this;
    }
    /// The whole object; it has a member at least.
    std::string text() { return std::move(text_ += '}'); }

private:
    std::string text_;
};

/// RFC 3339, or null.
inline nlohmann::json time_or_null(const std::optional<int64_t>& ms) {
    return ms ? nlohmann::json(rfc3339(*ms)) : nlohmann::json();
}

/// The id of the comparison, or of the sequence, that a job of that role belongs to; null where it belongs to none.
inline nlohmann::json group_json(GroupKind kind, JobRole role, const std::optional<int64_t>& group) {
    const bool belongs = group && (role == JobRole::Frame) == (kind == GroupKind::Sequence);
    return belongs ? nlohmann::json(group_id(kind, *group)) : nlohmann::json();
}

}  // namespace photond
