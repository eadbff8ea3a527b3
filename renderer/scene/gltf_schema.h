#pragma once
// What a JSON value must be, as a table: the language that gltf_judge.cpp is written in. Judging makes the tree plain:
// whole numbers become unsigned, other numbers floating-point, absent members with a default are put in, and members
// that the table does not name go.

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "renderer/scene/gltf_json.h"

namespace photond {

struct JsonMember;

struct JsonType {
    enum class Kind : uint8_t { Text, Boolean, Number, Whole, Index, OneOf, Array, Map, Object, Any };
    /// What holds beyond the table: of a value of a tree whose parts have been judged sound.
    using Rule = void (*)(const Json& root, const Json& value);

    Kind kind = Kind::Text;
    double min = 0, max = 0;                                  // of a number, inclusive
    double above = -std::numeric_limits<double>::infinity();  // ... and, as a float, greater than this
    size_t min_size = 0, max_size = SIZE_MAX;                 // of an array
    std::string_view words{};           // OneOf: "A|B|C"; Index: the array of the root that it counts in
    const JsonType* element = nullptr;  // of an array, or of a map, whose keys are anything
    bool gathered = false;              // an array whose elements' faults are gathered, one each
    std::span<const JsonMember> members{};
    Rule rule = nullptr;
    Rule element_rule = nullptr;  // of the objects in an array without `element`
};

struct JsonMember {
    std::string_view key;
    JsonType type;
    bool required = false;
    bool extension = false;          // a member of "extensions" by that name
    bool chosen = false;             // required where the member "type" holds this one's key, else passed over
    std::optional<double> absent{};  // what is put in its place; also in place of anything, Kind::Any
};

/// Judges members of the root, one after another. Throws one photond::Error that names all their faults.
void judge_layer(Json& root, std::span<const JsonMember> members);

/// Erases the members of an object, or of an object "extensions", that are not named.
void keep_members(Json& object, std::span<const JsonMember> members, bool extensions = false);

namespace schema {

using Kind = JsonType::Kind;

/// Any number that survives the conversion to float.
inline constexpr double kAny = std::numeric_limits<float>::max();

inline constexpr JsonType kText{}, kBoolean{.kind = Kind::Boolean};
constexpr JsonType number(double min, double max) { return {.kind = Kind::Number, .min = min, .max = max}; }
constexpr JsonType above(double limit, double max) { return {.kind = Kind::Number, .max = max, .above = limit}; }
constexpr JsonType whole(uint64_t min, uint64_t max) {
    return {.kind = Kind::Whole, .min = static_cast<double>(min), .max = static_cast<double>(max)};
}
constexpr JsonType index(std::string_view array) { return {.kind = Kind::Index, .words = array}; }
constexpr JsonType one_of(std::string_view words) { return {.kind = Kind::OneOf, .words = words}; }
constexpr JsonType list(const JsonType& element, size_t min_size = 0, size_t max_size = SIZE_MAX) {
    return {.kind = Kind::Array, .min_size = min_size, .max_size = max_size, .element = &element};
}
/// Objects, whose faults are gathered.
constexpr JsonType each(std::span<const JsonMember> members, JsonType::Rule element_rule = nullptr, size_t min_size = 0,
                        JsonType::Rule rule = nullptr) {
    return {.kind = Kind::Array,
            .min_size = min_size,
            .gathered = true,
            .members = members,
            .rule = rule,
            .element_rule = element_rule};
}
constexpr JsonType map(const JsonType& element) { return {.kind = Kind::Map, .element = &element}; }
constexpr JsonType object(std::span<const JsonMember> members, JsonType::Rule rule = nullptr) {
    return {.kind = Kind::Object, .members = members, .rule = rule};
}

template <class... Members>
constexpr std::array<JsonMember, sizeof...(Members)> members(const Members&... all) {
    return {all...};
}
constexpr JsonMember may(std::string_view key, const JsonType& type) { return {.key = key, .type = type}; }
constexpr JsonMember must(std::string_view key, const JsonType& type) {
    return {.key = key, .type = type, .required = true};
}
constexpr JsonMember extends(std::string_view key, const JsonType& type) {
    return {.key = key, .type = type, .extension = true};
}
constexpr JsonMember chosen(std::string_view key, const JsonType& type) {
    return {.key = key, .type = type, .chosen = true};
}
constexpr JsonMember absent(std::string_view key, const JsonType& type, double value) {
    return {.key = key, .type = type, .absent = value};
}

}  // namespace schema

}  // namespace photond
