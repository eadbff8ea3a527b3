#pragma once
// JSON as it may come from a stranger: bounded size and depth, no duplicate keys, and a place for every fault.

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace photond {

struct JsonLimits {
    size_t max_bytes = size_t{1} << 20;
    size_t max_depth =
        32;  // objects and arrays inside each other; nlohmann's own code recurses on the depth of a value
    size_t max_values = 100'000;  // members and elements, all levels together
};

/// Parses UTF-8 text. Throws Error: PayloadTooLarge past max_bytes, else BadJson with line and column in the message
/// (and the pointer of a duplicate key).
nlohmann::json parse_strict_json(std::string_view text, const JsonLimits& limits = {});

/// One reference token of a JSON pointer (RFC 6901), escaped.
std::string pointer_token(std::string_view key);

}  // namespace photond
