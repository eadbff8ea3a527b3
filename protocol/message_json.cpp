#include "protocol/message_json.h"

#include <limits>

namespace photond {

using nlohmann::json;

namespace {

constexpr const char* kTypeMember = "type";

}  // namespace

std::string_view type_of_message(const json& message) {
    const auto type = message.find(kTypeMember);
    if (type == message.end() || !type->is_string()) return {};
    return type->get_ref<const std::string&>();
}

void set_type_of_message(json& message, const char* type) { message[kTypeMember] = type; }

// --- Writing

bool MessageWriter::enter(const char* name, Presence presence) {
    if (presence == Presence::LeftOut) return false;
    json& member = (*at_.back())[name];
    if (presence == Presence::Null) {
        member = nullptr;
        return false;
    }
    at_.push_back(&member);
    return true;
}

void MessageWriter::enter_element(size_t index) { at_.push_back(&(*at_.back())[index]); }

void MessageWriter::begin_object() {
    if (!at_.back()->is_object()) *at_.back() = json::object();
}

size_t MessageWriter::begin_list(size_t size) {
    *at_.back() = json::array_t(size);
    return size;
}

void MessageWriter::scalar(bool& value) { *at_.back() = value; }
void MessageWriter::scalar(uint32_t& value) { *at_.back() = value; }
void MessageWriter::scalar(uint64_t& value) { *at_.back() = value; }
void MessageWriter::scalar(int64_t& value) { *at_.back() = value; }
void MessageWriter::scalar(double& value) { *at_.back() = value; }
void MessageWriter::scalar(std::string& value) { *at_.back() = std::move(value); }
void MessageWriter::scalar(std::filesystem::path& value) { *at_.back() = value.string(); }
void MessageWriter::scalar(json& value) { *at_.back() = std::move(value); }

// --- Reading

void MessageReader::fail(ErrorCode code, const std::string& fault) const {
    throw Error(code, pointer_,
                std::string("\"").append(what_).append("\": ").append(pointer_).append(" ").append(fault));
}

void MessageReader::fail_type(const char* wanted) const {
    fail(ErrorCode::WrongType, std::string("must be ") + wanted + ", not of type " + at_.back()->type_name());
}

void MessageReader::go_to(const json& value, const std::string& token) {
    pointer_lengths_.push_back(pointer_.size());
    pointer_ += "/" + token;
    at_.push_back(&value);
}

bool MessageReader::enter(const char* name, Presence presence) {
    const auto member = at_.back()->find(name);
    const bool absent = member == at_.back()->end() || member->is_null();
    if (absent && presence == Presence::Always) {
        pointer_.append("/").append(name);
        fail(ErrorCode::MissingField, "is missing");
    }
    if (!absent) go_to(*member, name);
    return !absent;
}

void MessageReader::enter_element(size_t index) { go_to((*at_.back())[index], std::to_string(index)); }

void MessageReader::leave() {
    at_.pop_back();
    pointer_.resize(pointer_lengths_.back());
    pointer_lengths_.pop_back();
}

void MessageReader::begin_object() {
    if (!at_.back()->is_object()) fail_type("an object");
}

size_t MessageReader::begin_list(size_t) {
    if (!at_.back()->is_array()) fail_type("a list");
    return at_.back()->size();
}

template <class Integer>
void MessageReader::read_integer(Integer& value) const {
    const json& source = *at_.back();
    if (!source.is_number_integer()) fail_type("a whole number");
    const bool fits = source.is_number_unsigned() ? std::in_range<Integer>(source.get<uint64_t>())
                                                  : std::in_range<Integer>(source.get<int64_t>());
    if (!fits)
        fail(ErrorCode::OutOfRange, "= " + source.dump() + " is outside [" +
                                        std::to_string(std::numeric_limits<Integer>::min()) + ", " +
                                        std::to_string(std::numeric_limits<Integer>::max()) + "]");
    value = source.get<Integer>();
}

void MessageReader::scalar(bool& value) {
    if (!at_.back()->is_boolean()) fail_type("true or false");
    value = at_.back()->get<bool>();
}
void MessageReader::scalar(uint32_t& value) { read_integer(value); }
void MessageReader::scalar(uint64_t& value) { read_integer(value); }
void MessageReader::scalar(int64_t& value) { read_integer(value); }
void MessageReader::scalar(double& value) {
    if (!at_.back()->is_number()) fail_type("a number");
    value = at_.back()->get<double>();
}
void MessageReader::scalar(std::string& value) {
    if (!at_.back()->is_string()) fail_type("text");
    value = at_.back()->get_ref<const std::string&>();
}
void MessageReader::scalar(std::filesystem::path& value) {
    std::string text;
    scalar(text);
    value = std::move(text);
}
void MessageReader::scalar(json& value) { value = *at_.back(); }

}  // namespace photond
