#pragma once
// A member of what the daemon answered, where it may be absent.

#include <nlohmann/json.hpp>

namespace photond::cli {

/// Null where `object` is no object or has no such member.
inline nlohmann::json member(const nlohmann::json& object, const char* key) {
    return object.is_object() && object.contains(key) ? object[key] : nlohmann::json();
}

}  // namespace photond::cli
