#include "renderer/scene/gltf_json.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

namespace photond {

namespace {

[[noreturn]] void bad_json(std::string pointer, const std::string& detail) {
    throw Error(ErrorCode::BadScene, std::move(pointer), detail);
}

/// Receives the parser's events and builds the tree bottom-up: the open containers' parts wait on a stack and move to
/// the arena, in one piece, when their container closes.
class TreeBuilder : public nlohmann::json_sax<nlohmann::json> {
public:
    TreeBuilder(std::pmr::memory_resource& arena, const JsonBounds& bounds) : arena_(arena), bounds_(bounds) {}

    JsonValue root;

    bool null() override { return put({}); }
    bool boolean(bool value) override {
        JsonValue v;
        v.kind = JsonValue::Kind::Bool;
        v.boolean = value;
        return put(v);
    }
    bool number_integer(number_integer_t value) override { return put_number(static_cast<double>(value)); }
    bool number_unsigned(number_unsigned_t value) override { return put_number(static_cast<double>(value)); }
    bool number_float(number_float_t value, const string_t&) override { return put_number(value); }
    bool string(string_t& text) override {
        JsonValue v;
        v.kind = JsonValue::Kind::String;
        const std::string_view kept = keep(text);
        v.size = static_cast<uint32_t>(kept.size());
        v.text = kept.data();
        return put(v);
    }
    bool binary(binary_t&) override { return false; }  // not in JSON text
    bool start_object(size_t) override { return open(true); }
    bool start_array(size_t) override { return open(false); }
    bool key(string_t& text) override {
        open_.back().key = keep(text);
        return true;
    }
    bool end_object() override {
        const Container container = open_.back();
        JsonValue v;
        v.kind = JsonValue::Kind::Object;
        const std::span<const JsonMember> parts(members_.data() + container.first, members_.size() - container.first);
        refuse_duplicates(parts);
        v.size = static_cast<uint32_t>(parts.size());
        v.members = keep_all(parts);
        members_.resize(container.first);
        open_.pop_back();
        return put(v);
    }
    bool end_array() override {
        const Container container = open_.back();
        JsonValue v;
        v.kind = JsonValue::Kind::Array;
        const std::span<const JsonValue> parts(values_.data() + container.first, values_.size() - container.first);
        v.size = static_cast<uint32_t>(parts.size());
        v.elements = keep_all(parts);
        values_.resize(container.first);
        open_.pop_back();
        return put(v);
    }
    bool parse_error(size_t position, const std::string&, const nlohmann::detail::exception& error) override {
        // The library's own text starts with an identifier in brackets that means nothing to the reader.
        const std::string_view what = error.what();
        const size_t bracket = what.find("] ");
        bad_json("",
                 "the glTF's JSON is malformed at byte " + std::to_string(position) + ": " +
                     std::string(bracket == std::string_view::npos ? what : what.substr(bracket + 2)).substr(0, 300));
    }

private:
    struct Container {
        bool object;
        size_t first;          // of its parts on the stack
        std::string_view key;  // of the member at hand
    };

    bool open(bool object) {
        if (open_.size() >= bounds_.max_depth)
            bad_json(pointer(), "the JSON is nested deeper than " + std::to_string(bounds_.max_depth) + " levels");
        open_.push_back({object, object ? members_.size() : values_.size(), {}});
        return true;
    }
    bool put_number(double number) {
        JsonValue v;
        v.kind = JsonValue::Kind::Number;
        v.number = number;
        return put(v);
    }
    bool put(const JsonValue& value) {
        if (++count_ > bounds_.max_values)
            bad_json("", "the JSON holds more than " + std::to_string(bounds_.max_values) + " values");
        if (open_.empty())
            root = value;
        else if (open_.back().object)
            members_.push_back({open_.back().key, value});
        else
            values_.push_back(value);
        return true;
    }
    std::string_view keep(const std::string& text) {
        if (text.size() > UINT32_MAX) bad_json(pointer(), "a string of more than 4 GiB");
        if (text.empty()) return {};
        char* copy = static_cast<char*>(arena_.allocate(text.size(), 1));
        std::memcpy(copy, text.data(), text.size());
        return {copy, text.size()};
    }
    template <class T>
    const T* keep_all(std::span<const T> parts) {
        if (parts.empty()) return nullptr;
        T* copy = static_cast<T*>(arena_.allocate(parts.size_bytes(), alignof(T)));
        std::uninitialized_copy(parts.begin(), parts.end(), copy);
        return copy;
    }
    void refuse_duplicates(std::span<const JsonMember> members) const {
        std::vector<std::string_view> keys(members.size());
        std::ranges::transform(members, keys.begin(), &JsonMember::key);
        std::ranges::sort(keys);
        const auto twice = std::ranges::adjacent_find(keys);
        if (twice == keys.end()) return;
        bad_json(pointer(1) + json_pointer_token(*twice),
                 "the key \"" + std::string(twice->substr(0, 80)) + "\" occurs twice in one object");
    }
    /// Of the value being read, without the innermost `omit` containers' own parts.
    std::string pointer(size_t omit = 0) const {
        std::string result;
        size_t values_end = values_.size();
        std::vector<std::string> tokens;
        for (size_t level = open_.size(); level-- > 0;) {
            const Container& c = open_[level];
            tokens.push_back(json_pointer_token(c.object ? std::string(c.key) : std::to_string(values_end - c.first)));
            if (!c.object) values_end = c.first;
        }
        for (size_t i = tokens.size(); i-- > omit;) result += tokens[i];
        return result;
    }

    std::pmr::memory_resource& arena_;
    const JsonBounds& bounds_;
    std::vector<Container> open_;
    std::vector<JsonValue> values_;
    std::vector<JsonMember> members_;
    uint64_t count_ = 0;
};

/// Depth is bounded by JsonBounds::max_depth.
bool find_path(const JsonValue& from, const JsonValue* target, std::string& path) {
    if (&from == target) return true;
    const size_t length = path.size();
    for (uint32_t i = 0; i < from.size; ++i) {
        const JsonValue* child = nullptr;
        if (from.kind == JsonValue::Kind::Array) child = &from.elements[i];
        if (from.kind == JsonValue::Kind::Object) child = &from.members[i].value;
        if (child == nullptr) return false;
        if (child != target && (child->kind != JsonValue::Kind::Array && child->kind != JsonValue::Kind::Object))
            continue;
        path += json_pointer_token(from.kind == JsonValue::Kind::Array ? std::to_string(i)
                                                                       : std::string(from.members[i].key));
        if (find_path(*child, target, path)) return true;
        path.resize(length);
    }
    return false;
}

std::string shortest(double number) {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", number);
    return text;
}

}  // namespace

std::string json_pointer_token(std::string_view token) {
    std::string escaped = "/";
    for (const char c : token) {
        if (c == '~')
            escaped += "~0";
        else if (c == '/')
            escaped += "~1";
        else
            escaped += c;
    }
    return escaped;
}

JsonDocument::JsonDocument(std::string_view text, const JsonBounds& bounds) {
    TreeBuilder builder(arena_, bounds);
    nlohmann::json::sax_parse(text.begin(), text.end(), &builder);
    root_ = builder.root;
}

JsonRef JsonDocument::root() const { return {*this, root_}; }

std::string JsonDocument::pointer_to(const JsonValue* value) const {
    std::string path;
    find_path(root_, value, path);
    return path;
}

void JsonRef::fail(const std::string& detail, ErrorCode code) const { throw Error(code, pointer(), detail); }

std::optional<JsonRef> JsonRef::find(std::string_view key) const {
    if (!is_object()) fail("must be an object, not " + shown());
    for (uint32_t i = 0; i < value_->size; ++i)
        if (value_->members[i].key == key) return JsonRef(*document_, value_->members[i].value);
    return std::nullopt;
}

JsonRef JsonRef::require(std::string_view key) const {
    if (const auto member = find(key)) return *member;
    throw Error(ErrorCode::BadScene, pointer() + json_pointer_token(key), "\"" + std::string(key) + "\" is missing");
}

std::optional<JsonRef> JsonRef::extension(std::string_view name) const {
    const auto extensions = find("extensions");
    if (!extensions) return std::nullopt;
    const auto found = extensions->find(name);
    if (found && !found->is_object()) found->fail("must be an object, not " + found->shown());
    return found;
}

uint32_t JsonRef::array_size(uint32_t min, uint32_t max) const {
    if (value_->kind != JsonValue::Kind::Array) fail("must be an array, not " + shown());
    if (value_->size < min || value_->size > max)
        fail("has " + std::to_string(value_->size) + " elements, outside [" + std::to_string(min) + ", " +
             std::to_string(max) + "]");
    return value_->size;
}

JsonRef JsonRef::at(uint32_t index) const { return {*document_, value_->elements[index]}; }

std::string_view JsonRef::text() const {
    if (value_->kind != JsonValue::Kind::String) fail("must be a string, not " + shown());
    return {value_->text, value_->size};
}

bool JsonRef::boolean() const {
    if (value_->kind != JsonValue::Kind::Bool) fail("must be true or false, not " + shown());
    return value_->boolean;
}

double JsonRef::number(double min, double max) const {
    if (value_->kind != JsonValue::Kind::Number) fail("must be a number, not " + shown());
    if (!(value_->number >= min && value_->number <= max))
        fail(shown() + " is outside [" + shortest(min) + ", " + shortest(max) + "]");
    return value_->number;
}

uint64_t JsonRef::whole(uint64_t min, uint64_t max) const {
    if (value_->kind != JsonValue::Kind::Number) fail("must be a whole number, not " + shown());
    const double x = value_->number;
    constexpr double kExact = 9007199254740992.0;  // beyond 2^53 a double no longer tells whole numbers apart
    if (!(std::fabs(x) <= kExact) || x != std::floor(x)) fail("must be a whole number, not " + shown());
    if (x < static_cast<double>(min) || x > static_cast<double>(max))
        fail(shown() + " is outside [" + std::to_string(min) + ", " + std::to_string(max) + "]");
    return static_cast<uint64_t>(x);
}

uint32_t JsonRef::index(uint64_t count, std::string_view what) const {
    if (value_->kind == JsonValue::Kind::Number && value_->number >= static_cast<double>(count))
        fail(shown() + " is not an index into the " + std::to_string(count) + " " + std::string(what));
    return static_cast<uint32_t>(whole(0, count == 0 ? 0 : count - 1));
}

std::string_view JsonRef::text_or(std::string_view key, std::string_view fallback) const {
    const auto member = find(key);
    return member ? member->text() : fallback;
}

bool JsonRef::boolean_or(std::string_view key, bool fallback) const {
    const auto member = find(key);
    return member ? member->boolean() : fallback;
}

double JsonRef::number_or(std::string_view key, double fallback, double min, double max) const {
    const auto member = find(key);
    return member ? member->number(min, max) : fallback;
}

uint64_t JsonRef::whole_or(std::string_view key, uint64_t fallback, uint64_t min, uint64_t max) const {
    const auto member = find(key);
    return member ? member->whole(min, max) : fallback;
}

std::optional<uint32_t> JsonRef::index_or_none(std::string_view key, uint64_t count, std::string_view what) const {
    const auto member = find(key);
    if (!member) return std::nullopt;
    return member->index(count, what);
}

bool JsonRef::numbers(std::string_view key, std::span<double> out, double min, double max) const {
    const auto member = find(key);
    if (!member) return false;
    const auto size = static_cast<uint32_t>(out.size());
    member->array_size(size, size);
    for (uint32_t i = 0; i < size; ++i) out[i] = member->at(i).number(min, max);
    return true;
}

std::string JsonRef::shown() const {
    switch (value_->kind) {
        case JsonValue::Kind::Null: return "null";
        case JsonValue::Kind::Bool: return value_->boolean ? "true" : "false";
        case JsonValue::Kind::Number: return shortest(value_->number);
        case JsonValue::Kind::Array: return "an array";
        case JsonValue::Kind::Object: return "an object";
        case JsonValue::Kind::String: break;
    }
    const std::string_view text(value_->text, value_->size);
    return '"' + std::string(text.substr(0, 60)) + (text.size() > 60 ? "...\"" : "\"");
}

void FaultList::add(ErrorCode code, std::string pointer, std::string detail) {
    if (faults_.size() >= kMaxFaults) return;
    if (faults_.empty()) code_ = code;
    faults_.push_back({std::move(pointer), std::move(detail)});
}

void FaultList::add(const Error& error) {
    if (error.faults.empty()) return add(error.code, "", error.what());
    for (const Fault& fault : error.faults) add(error.code, fault.pointer, fault.detail);
}

void FaultList::throw_if_any() const {
    if (faults_.empty()) return;
    std::string detail = faults_.front().pointer + ": " + faults_.front().detail;
    if (faults_.front().pointer.empty()) detail = faults_.front().detail;
    if (faults_.size() > 1) detail += " (and " + std::to_string(faults_.size() - 1) + " more)";
    throw Error(code_, detail, faults_);
}

}  // namespace photond
