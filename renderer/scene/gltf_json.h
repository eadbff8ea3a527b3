#pragma once
// The JSON of a glTF file as a stranger may have written it: bounded depth and size, no duplicate keys, and a JSON
// pointer for every complaint. The library's parser is driven event by event into a compact tree, because its own tree
// takes the last of duplicate keys and is destroyed recursively.

#include <cstdint>
#include <memory_resource>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/error.h"

namespace photond {

/// `token` escaped as one reference token of a JSON pointer (RFC 6901), with its leading slash.
std::string json_pointer_token(std::string_view token);

struct JsonMember;

/// One value of the tree; 16 bytes, trivially copied, its parts live in the document's arena.
struct JsonValue {
    enum class Kind : uint8_t { Null, Bool, Number, String, Array, Object };

    Kind kind = Kind::Null;
    bool boolean = false;
    uint32_t size = 0;  // characters, elements or members
    union {
        double number = 0;
        const char* text;
        const JsonValue* elements;
        const JsonMember* members;
    };
};

struct JsonMember {
    std::string_view key;
    JsonValue value;
};

struct JsonBounds {
    uint32_t max_depth = 64;
    uint64_t max_values = 4'000'000;
};

class JsonRef;

class JsonDocument {
public:
    /// Parses UTF-8 text. Throws ErrorCode::BadScene with the byte position in the message and, where it lies inside
    /// the tree (a duplicate key), its pointer.
    JsonDocument(std::string_view text, const JsonBounds& bounds);
    JsonDocument(const JsonDocument&) = delete;

    JsonRef root() const;
    /// Where a value of this document is. Searches the whole tree: for complaints only.
    std::string pointer_to(const JsonValue* value) const;

private:
    std::pmr::monotonic_buffer_resource arena_;
    JsonValue root_;
};

/// A value of a document and the questions a reader asks of it. Each getter throws ErrorCode::BadScene with the value's
/// pointer when the value is not what was asked for.
class JsonRef {
public:
    JsonRef(const JsonDocument& document, const JsonValue& value) : document_(&document), value_(&value) {}

    [[noreturn]] void fail(const std::string& detail, ErrorCode code = ErrorCode::BadScene) const;
    std::string pointer() const { return document_->pointer_to(value_); }

    bool is_object() const { return value_->kind == JsonValue::Kind::Object; }
    /// The member of that name of an object; the value must be an object.
    std::optional<JsonRef> find(std::string_view key) const;
    JsonRef require(std::string_view key) const;
    /// extensions.NAME of this object.
    std::optional<JsonRef> extension(std::string_view name) const;

    /// Checks that this is an array and gives its length, which must lie within the bounds.
    uint32_t array_size(uint32_t min = 0, uint32_t max = UINT32_MAX) const;
    JsonRef at(uint32_t index) const;  // of an array, index < array_size()

    uint32_t member_count() const { return value_->size; }  // of an object
    std::string_view member_key(uint32_t index) const { return value_->members[index].key; }
    JsonRef member_value(uint32_t index) const { return {*document_, value_->members[index].value}; }

    std::string_view text() const;
    bool boolean() const;
    double number(double min = -kAnyNumber, double max = kAnyNumber) const;  // inclusive
    uint64_t whole(uint64_t min, uint64_t max) const;
    /// A whole number below `count`, which is the size of `what` (for the message).
    uint32_t index(uint64_t count, std::string_view what) const;

    // The same of an optional member, with the value that stands for its absence.
    std::string_view text_or(std::string_view key, std::string_view fallback) const;
    bool boolean_or(std::string_view key, bool fallback) const;
    double number_or(std::string_view key, double fallback, double min, double max) const;
    uint64_t whole_or(std::string_view key, uint64_t fallback, uint64_t min, uint64_t max) const;
    std::optional<uint32_t> index_or_none(std::string_view key, uint64_t count, std::string_view what) const;
    /// Fills `out` from an array of exactly that many numbers; false when there is no such member.
    bool numbers(std::string_view key, std::span<double> out, double min, double max) const;

    /// Any number that survives the conversion to float.
    static constexpr double kAnyNumber = 3.4028234663852886e38;

private:
    std::string shown() const;  // the value, shortened, for messages

    const JsonDocument* document_;
    const JsonValue* value_;
};

/// Gathers faults so that one answer names them all (the first kMaxFaults of them).
class FaultList {
public:
    static constexpr size_t kMaxFaults = 16;

    void add(ErrorCode code, std::string pointer, std::string detail);
    void add(const Error& error);
    /// Runs a step and keeps the photond::Error it may throw.
    template <class Step>
    void collect(const Step& step) {
        if (faults_.size() >= kMaxFaults) return;
        try {
            step();
        } catch (const Error& error) {
            add(error);
        }
    }
    /// Throws one Error with every fault and the code of the first; does nothing when there is none.
    void throw_if_any() const;

private:
    ErrorCode code_ = ErrorCode::BadScene;
    std::vector<Fault> faults_;
};

}  // namespace photond
