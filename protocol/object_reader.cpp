#include "protocol/object_reader.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "protocol/param_json.h"
#include "protocol/strict_json.h"

namespace photond {

using nlohmann::json;

void BodyFaults::add(ErrorCode code, std::string pointer, std::string detail) {
    if (size() == 0) first_ = code;
    if (faults_.size() >= kMostListed) {
        ++left_out_;
        return;
    }
    faults_.emplace_back(code, std::move(pointer), std::move(detail));
}

void BodyFaults::take(ErrorCode code, std::vector<Fault>&& faults) {
    if (size() == 0 && !faults.empty()) first_ = code;
    for (Fault& fault : faults)
        if (faults_.size() >= kMostListed)
            ++left_out_;
        else
            faults_.push_back(std::move(fault));
}

void BodyFaults::throw_if_any() const {
    if (size() == 0) return;
    const Fault& first = faults_.front();
    std::string detail = (first.pointer.empty() ? "" : first.pointer + ": ") + first.detail;
    if (size() > 1) detail = std::to_string(size()) + " faults; the first is at " + detail;
    if (left_out_ > 0) detail += "; only the first " + std::to_string(faults_.size()) + " are listed";
    throw Error(first_, detail, faults_);
}

namespace {
const json& empty_object() {
    static const json kEmpty = json::object();
    return kEmpty;
}
}  // namespace

ObjectReader::ObjectReader(const json& source, std::string pointer, BodyFaults& faults)
    : source_(source.is_object() ? &source : &empty_object()), pointer_(std::move(pointer)), faults_(faults) {
    if (!source.is_object())
        faults_.add(ErrorCode::WrongType, pointer_, "must be an object, got " + value_text(source));
}

std::string ObjectReader::at(const std::string& key) const { return pointer_ + "/" + pointer_token(key); }

const json* ObjectReader::member(const std::string& key, bool required) {
    known_.push_back(key);
    const auto found = source_->find(key);
    if (found != source_->end() && !found->is_null()) return &*found;
    if (required) faults_.add(ErrorCode::MissingField, at(key), "is required");
    return nullptr;
}

std::optional<std::string> ObjectReader::string(const std::string& key, size_t max_length, bool required) {
    const json* value = member(key, required);
    if (value == nullptr) return std::nullopt;
    if (!value->is_string()) {
        faults_.add(ErrorCode::WrongType, at(key), "must be a string, got " + value_text(*value));
        return std::nullopt;
    }
    auto text = value->get<std::string>();
    if (text.empty() || text.size() > max_length) {
        faults_.add(ErrorCode::OutOfRange, at(key),
                    "must have 1 to " + std::to_string(max_length) + " bytes, has " + std::to_string(text.size()));
        return std::nullopt;
    }
    for (const char c : text)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
            faults_.add(ErrorCode::OutOfRange, at(key), "must not contain control characters");
            return std::nullopt;
        }
    return text;
}

std::optional<double> ObjectReader::number(const std::string& key, const NumberRange& range, bool required) {
    const json* value = member(key, required);
    if (value == nullptr) return std::nullopt;
    if (!value->is_number()) {
        faults_.add(ErrorCode::WrongType, at(key), "must be a number, got " + value_text(*value));
        return std::nullopt;
    }
    const double x = value->get<double>();
    if (!(x >= range.min && x <= range.max)) {  // written so that NaN fails too
        faults_.add(ErrorCode::OutOfRange, at(key),
                    value_text(*value) + " is outside [" + number_text(range.min) + ", " + number_text(range.max) +
                        "]" + (*range.unit != '\0' ? std::string(" ") + range.unit : ""));
        return std::nullopt;
    }
    return x;
}

std::optional<int64_t> ObjectReader::integer(const std::string& key, int64_t min, int64_t max, bool required) {
    const json* value = member(key, required);
    if (value == nullptr) return std::nullopt;
    const bool whole = value->is_number_integer() ||
                       (value->is_number_float() && std::nearbyint(value->get<double>()) == value->get<double>());
    if (!whole) {
        faults_.add(ErrorCode::WrongType, at(key), "must be a whole number, got " + value_text(*value));
        return std::nullopt;
    }
    // Compared as doubles: limits here lie below 2^53, what is given may not fit 64 bits.
    const double x = value->get<double>();
    if (!(x >= static_cast<double>(min) && x <= static_cast<double>(max))) {
        faults_.add(ErrorCode::OutOfRange, at(key),
                    value_text(*value) + " is outside [" + std::to_string(min) + ", " + std::to_string(max) + "]");
        return std::nullopt;
    }
    return static_cast<int64_t>(x);
}

std::optional<uint64_t> ObjectReader::seed(const std::string& key) {
    const json* value = member(key);
    if (value == nullptr) return std::nullopt;
    if (value->is_number_unsigned()) return value->get<uint64_t>();
    if (value->is_number_float()) {
        const double x = value->get<double>();
        if (x >= 0 && x <= 0x1p53 && std::nearbyint(x) == x) return static_cast<uint64_t>(x);
    }
    if (!value->is_number())
        faults_.add(ErrorCode::WrongType, at(key), "must be a whole number, got " + value_text(*value));
    else
        faults_.add(ErrorCode::OutOfRange, at(key),
                    value_text(*value) + " is no whole number of [0, " +
                        std::to_string(std::numeric_limits<uint64_t>::max()) + "]");
    return std::nullopt;
}

std::optional<std::string> ObjectReader::word(const std::string& key, const std::vector<std::string>& words,
                                              bool required) {
    const json* value = member(key, required);
    if (value == nullptr) return std::nullopt;
    if (!value->is_string()) {
        faults_.add(ErrorCode::WrongType, at(key), "must be a string, got " + value_text(*value));
        return std::nullopt;
    }
    auto text = value->get<std::string>();
    if (std::find(words.begin(), words.end(), text) != words.end()) return text;
    std::string list;
    for (const std::string& known : words) list += (list.empty() ? "\"" : ", \"") + known + "\"";
    faults_.add(ErrorCode::UnknownName, at(key),
                value_text(*value) + " is not one of " + list + did_you_mean(text, words));
    return std::nullopt;
}

void ObjectReader::finish() {
    for (const auto& [key, value] : source_->items())
        if (std::find(known_.begin(), known_.end(), key) == known_.end())
            faults_.add(ErrorCode::UnknownField, at(key), "unknown field" + did_you_mean(key, known_));
}

}  // namespace photond
