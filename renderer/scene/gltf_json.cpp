#include "renderer/scene/gltf_json.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace photond {

namespace {

[[noreturn]] void bad_json(std::string pointer, const std::string& detail) {
    throw Error(ErrorCode::BadScene, std::move(pointer), detail);
}

/// Receives the parser's events and builds the tree. The library's own builder takes the last of duplicate keys and
/// knows no bounds; a very deep tree crashes what walks it.
class TreeBuilder : public nlohmann::json_sax<Json> {
public:
    explicit TreeBuilder(const JsonBounds& bounds) : bounds_(bounds) {}

    Json root;

    bool null() override { return put(nullptr); }
    bool boolean(bool value) override { return put(value); }
    bool number_integer(number_integer_t value) override { return put(value); }
    bool number_unsigned(number_unsigned_t value) override { return put(value); }
    bool number_float(number_float_t value, const string_t&) override { return put(value); }
    bool string(string_t& text) override { return put(std::move(text)); }
    bool binary(binary_t&) override { return false; }  // not in JSON text
    bool start_object(size_t) override { return open(Json::object()); }
    bool start_array(size_t) override { return open(Json::array()); }
    bool end_object() override {
        refuse_duplicates();
        return close();
    }
    bool end_array() override { return close(); }
    bool key(string_t& text) override {
        // The container's own way to add a member looks through all that are there.
        open_.back()->get_ref<Json::object_t&>().emplace_back(std::move(text), nullptr);
        return true;
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
    Json* add(Json value) {
        if (++count_ > bounds_.max_values)
            bad_json("", "the JSON holds more than " + std::to_string(bounds_.max_values) + " values");
        if (open_.empty()) return &(root = std::move(value));
        Json& parent = *open_.back();
        Json& place = parent.is_array() ? parent.emplace_back() : parent.get_ref<Json::object_t&>().back().second;
        return &(place = std::move(value));
    }
    bool put(Json value) { return add(std::move(value)) != nullptr; }
    bool open(Json container) {
        if (open_.size() >= bounds_.max_depth) {
            if (open_.back()->is_array()) open_.back()->emplace_back();
            bad_json(pointer(open_.size()),
                     "the JSON is nested deeper than " + std::to_string(bounds_.max_depth) + " levels");
        }
        open_.push_back(add(std::move(container)));
        return true;
    }
    bool close() {
        open_.pop_back();
        return true;
    }
    void refuse_duplicates() const {
        std::vector<std::string_view> keys;
        for (const auto& member : open_.back()->get_ref<const Json::object_t&>()) keys.emplace_back(member.first);
        std::ranges::sort(keys);
        if (const auto twice = std::ranges::adjacent_find(keys); twice != keys.end())
            bad_json(pointer(open_.size() - 1) + json_pointer_token(*twice),
                     "the key \"" + std::string(twice->substr(0, 80)) + "\" occurs twice in one object");
    }
    /// Of the last value so far in the innermost of the outermost `levels` containers.
    std::string pointer(size_t levels) const {
        std::string result;
        for (size_t level = 0; level < levels; ++level) {
            const Json& open = *open_[level];
            result += json_pointer_token(open.is_array() ? std::to_string(open.size() - 1)
                                                         : open.get_ref<const Json::object_t&>().back().first);
        }
        return result;
    }

    const JsonBounds& bounds_;
    std::vector<Json*> open_;  // the containers around the value to come, the last of their parents' values
    uint64_t count_ = 0;
};

/// Depth is bounded by JsonBounds::max_depth.
bool find_path(const Json& from, const Json* target, std::string& path) {
    if (&from == target) return true;
    if (!from.is_structured()) return false;
    const size_t length = path.size();
    size_t index = 0;
    for (auto child = from.begin(); child != from.end(); ++child, ++index) {
        if (&*child != target && !child->is_structured()) continue;
        path += json_pointer_token(from.is_array() ? std::to_string(index) : child.key());
        if (find_path(*child, target, path)) return true;
        path.resize(length);
    }
    return false;
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

Json parse_json(std::string_view text, const JsonBounds& bounds) {
    TreeBuilder builder(bounds);
    Json::sax_parse(text.begin(), text.end(), &builder);
    return std::move(builder.root);
}

void fail(const Json& at, const std::string& detail, ErrorCode code) { throw JsonFault{&at, "", detail, code}; }

std::string shown(const Json& value) {
    if (value.is_structured()) return value.is_object() ? "an object" : "an array";
    if (value.is_string()) {
        const auto& text = value.get_ref<const std::string&>();
        return '"' + text.substr(0, 60) + (text.size() > 60 ? "...\"" : "\"");
    }
    if (!value.is_number()) return value.dump();
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.9g", value.get<double>());
    return digits;
}

Json* find_member(Json& object, std::string_view key) {
    if (!object.is_object()) fail(object, "must be an object, not " + shown(object));
    for (auto& member : object.get_ref<Json::object_t&>())
        if (member.first == key) return &member.second;
    return nullptr;
}

const Json* find_member(const Json& object, std::string_view key) {
    return find_member(const_cast<Json&>(object), key);
}

const Json* find_extension(const Json& object, std::string_view name) {
    const Json* extensions = find_member(object, "extensions");
    return extensions == nullptr ? nullptr : find_member(*extensions, name);
}

void FaultList::add(ErrorCode code, std::string pointer, std::string detail) {
    // Several elements may refer to the same faulty one.
    const auto same = [&](const Fault& fault) { return fault.pointer == pointer && fault.detail == detail; };
    if (faults_.size() >= kMaxFaults || std::ranges::any_of(faults_, same)) return;
    if (faults_.empty()) code_ = code;
    faults_.emplace_back(code, std::move(pointer), std::move(detail));
}

void FaultList::add(const JsonFault& fault, const Json& root) {
    std::string pointer;
    find_path(root, fault.at, pointer);
    add(fault.code, pointer + (fault.member.empty() ? "" : json_pointer_token(fault.member)), fault.detail);
}

void FaultList::throw_if_any() const {
    if (faults_.empty()) return;
    std::string detail = faults_.front().pointer + ": " + faults_.front().detail;
    if (faults_.front().pointer.empty()) detail = faults_.front().detail;
    if (faults_.size() > 1) detail += " (and " + std::to_string(faults_.size() - 1) + " more)";
    throw Error(code_, detail, faults_);
}

}  // namespace photond
