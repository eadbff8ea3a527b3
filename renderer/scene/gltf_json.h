#pragma once
// The JSON of a glTF file as a stranger may have written it: bounded depth and size, no duplicate keys, and a JSON
// pointer for every complaint.

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/error.h"

namespace photond {

using Json = nlohmann::ordered_json;  // members in the file's order

/// `token` escaped as one reference token of a JSON pointer (RFC 6901), with its leading slash.
std::string json_pointer_token(std::string_view token);

/// "/accessors/3" and the like, with further tokens: gltf_pointer("accessors", 3, "sparse", "indices").
template <class... Tokens>
std::string gltf_pointer(std::string_view array, uint64_t index, const Tokens&... tokens) {
    std::string pointer = json_pointer_token(array) + json_pointer_token(std::to_string(index));
    ((pointer += json_pointer_token(tokens)), ...);
    return pointer;
}

struct JsonBounds {
    uint32_t max_depth = 64;
    uint64_t max_values = 4'000'000;
};

/// Parses UTF-8 text. Throws ErrorCode::BadScene with the byte position in the message and, where it lies inside the
/// tree (a duplicate key), its pointer.
Json parse_json(std::string_view text, const JsonBounds& bounds);

/// What is wrong with a value of a tree.
struct JsonFault {
    const Json* at;
    std::string member;  // of `at` that is missing
    std::string detail;
    ErrorCode code;
};
[[noreturn]] void fail(const Json& at, const std::string& detail, ErrorCode code = ErrorCode::BadScene);
/// A value, shortened, for messages.
std::string shown(const Json& value);

/// A member of an object, or null. Fails where the value is no object.
Json* find_member(Json& object, std::string_view key);
const Json* find_member(const Json& object, std::string_view key);
/// extensions.NAME of an object, or null.
const Json* find_extension(const Json& object, std::string_view name);

/// Gathers faults so that one answer names them all (the first kMaxFaults of them), each once.
class FaultList {
public:
    static constexpr size_t kMaxFaults = 16;

    void add(ErrorCode code, std::string pointer, std::string detail);
    /// `root`: of the tree that holds the value.
    void add(const JsonFault& fault, const Json& root);
    size_t size() const { return faults_.size(); }
    /// Throws one Error with every fault and the code of the first; does nothing when there is none.
    void throw_if_any() const;

private:
    ErrorCode code_ = ErrorCode::BadScene;
    std::vector<Fault> faults_;
};

}  // namespace photond
