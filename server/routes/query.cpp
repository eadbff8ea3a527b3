#include "server/routes/query.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "protocol/param_json.h"
#include "protocol/strict_json.h"

namespace photond::http {
namespace {

std::optional<double> number_in(std::string_view text) {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc() && end == text.data() + text.size() && std::isfinite(value)) return value;
    return std::nullopt;
}

}  // namespace

std::string Query::text(const std::string& name, const std::string& otherwise) {
    known_.push_back(name);
    const auto found = values_.find(name);
    return found == values_.end() ? otherwise : found->second;
}

std::vector<std::string> Query::list(const std::string& name) {
    std::vector<std::string> items;
    std::istringstream given(text(name));
    for (std::string item; std::getline(given, item, ',');) items.push_back(item);
    return items;
}

double Query::number(const std::string& name, double otherwise) { return number(name).value_or(otherwise); }

std::optional<double> Query::number(const std::string& name) {
    const std::string given = text(name);
    if (given.empty()) return std::nullopt;
    const std::optional<double> value = number_in(given);
    if (!value) faults_.emplace_back(ErrorCode::WrongType, "/" + name, "must be a number, got " + value_text(given));
    return value;
}

std::optional<std::array<double, 3>> Query::point(const std::string& name) {
    const std::string given = text(name);
    if (given.empty()) return std::nullopt;
    const size_t first = given.find(','), second = given.find(',', first + 1);
    if (first != std::string::npos && second != std::string::npos) {
        const auto x = number_in(std::string_view(given).substr(0, first));
        const auto y = number_in(std::string_view(given).substr(first + 1, second - first - 1));
        const auto z = number_in(std::string_view(given).substr(second + 1));
        if (x && y && z) return std::array{*x, *y, *z};
    }
    faults_.emplace_back(ErrorCode::WrongType, "/" + name,
                         "must be three numbers with commas between them, got " + value_text(given));
    return std::nullopt;
}

uint32_t Query::integer(const std::string& name, uint32_t otherwise) { return integer(name).value_or(otherwise); }

std::optional<uint32_t> Query::integer(const std::string& name) {
    const std::string given = text(name);
    if (given.empty()) return std::nullopt;
    uint32_t value = 0;
    const auto [end, error] = std::from_chars(given.data(), given.data() + given.size(), value);
    if (error == std::errc() && end == given.data() + given.size()) return value;
    faults_.emplace_back(ErrorCode::WrongType, "/" + name, "must be a whole number, got " + value_text(given));
    return std::nullopt;
}

bool Query::flag(const std::string& name, bool otherwise) {
    const std::string given = text(name, otherwise ? "true" : "false");
    if (given != "true" && given != "false")
        faults_.emplace_back(ErrorCode::WrongType, "/" + name, "must be true or false, got " + value_text(given));
    return given == "true";
}

void Query::finish() {
    ErrorCode code = ErrorCode::OutOfRange;
    for (auto at = values_.begin(); at != values_.end(); at = values_.upper_bound(at->first)) {
        const std::string& name = at->first;
        const std::string pointer = "/" + pointer_token(name.substr(0, 64));
        if (std::find(known_.begin(), known_.end(), name) == known_.end()) {
            if (faults_.empty()) code = ErrorCode::UnknownField;
            faults_.emplace_back(ErrorCode::UnknownField, pointer,
                                 "unknown query parameter" + did_you_mean(name, known_));
        } else if (values_.count(name) > 1) {
            faults_.emplace_back(ErrorCode::Conflict, pointer, "is given more than once");
        }
    }
    if (faults_.empty()) return;
    const std::string detail = "in the query, " + faults_[0].pointer.substr(1) + ": " + faults_[0].detail;
    throw Error(code, detail, std::move(faults_));
}

}  // namespace photond::http
