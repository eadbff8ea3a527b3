#include "server/routes/query.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "protocol/param_json.h"
#include "protocol/strict_json.h"

namespace photond::http {

std::string Query::text(const std::string& name, const std::string& otherwise) {
    known_.push_back(name);
    const auto found = values_.find(name);
    return found == values_.end() ? otherwise : found->second;
}

double Query::number(const std::string& name, double otherwise) {
    const std::string given = text(name);
    if (given.empty()) return otherwise;
    double value = 0;
    const auto [end, error] = std::from_chars(given.data(), given.data() + given.size(), value);
    if (error == std::errc() && end == given.data() + given.size() && std::isfinite(value)) return value;
    faults_.push_back({"/" + name, "must be a number, got " + value_text(given)});
    return otherwise;
}

uint32_t Query::integer(const std::string& name, uint32_t otherwise) { return integer(name).value_or(otherwise); }

std::optional<uint32_t> Query::integer(const std::string& name) {
    const std::string given = text(name);
    if (given.empty()) return std::nullopt;
    uint32_t value = 0;
    const auto [end, error] = std::from_chars(given.data(), given.data() + given.size(), value);
    if (error == std::errc() && end == given.data() + given.size()) return value;
    faults_.push_back({"/" + name, "must be a whole number, got " + value_text(given)});
    return std::nullopt;
}

bool Query::flag(const std::string& name) {
    const std::string given = text(name, "false");
    if (given != "true" && given != "false")
        faults_.push_back({"/" + name, "must be true or false, got " + value_text(given)});
    return given == "true";
}

void Query::finish() {
    ErrorCode code = ErrorCode::OutOfRange;
    for (auto at = values_.begin(); at != values_.end(); at = values_.upper_bound(at->first)) {
        const std::string& name = at->first;
        const std::string pointer = "/" + pointer_token(name.substr(0, 64));
        if (std::find(known_.begin(), known_.end(), name) == known_.end()) {
            if (faults_.empty()) code = ErrorCode::UnknownField;
            faults_.push_back({pointer, "unknown query parameter" + did_you_mean(name, known_)});
        } else if (values_.count(name) > 1) {
            faults_.push_back({pointer, "is given more than once"});
        }
    }
    if (faults_.empty()) return;
    const std::string detail = "in the query, " + faults_[0].pointer.substr(1) + ": " + faults_[0].detail;
    throw Error(code, detail, std::move(faults_));
}

}  // namespace photond::http
