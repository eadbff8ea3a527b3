#pragma once
// Fields of the helper's requests (worker_messages.h).

#include <nlohmann/json.hpp>
#include <string>

#include "protocol/error.h"

namespace photond {

/// A member that must be text. Throws ErrorCode::MissingField at its pointer.
inline std::string text_of(const nlohmann::json& message, const char* key) {
    const auto member = message.find(key);
    if (member == message.end() || !member->is_string())
        throw Error(ErrorCode::MissingField, std::string("/") + key, "must be a string");
    return member->get<std::string>();
}

}  // namespace photond
