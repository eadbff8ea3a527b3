#include "server/routes/accept.h"

#include <charconv>
#include <string_view>

#include "protocol/error.h"

namespace photond::http {
namespace {

std::string_view trimmed(std::string_view text) {
    const size_t first = text.find_first_not_of(" \t");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

/// How closely a range names a type: 3 by its name, 2 by "image/*", 1 by "*/*", 0 not at all.
int closeness(std::string_view range, std::string_view type) {
    if (range == type) return 3;
    if (range == "*/*") return 1;
    const size_t slash = type.find('/');
    return range.size() == slash + 2 && range.substr(0, slash + 1) == type.substr(0, slash + 1) && range.back() == '*'
               ? 2
               : 0;
}

/// The weight of a range's parameters; 1 where they say none.
double weight_of(std::string_view parameters) {
    while (!parameters.empty()) {
        const size_t end = parameters.find(';');
        const std::string_view one = trimmed(parameters.substr(0, end));
        double weight = 0;
        if (one.starts_with("q=") && std::from_chars(one.data() + 2, one.data() + one.size(), weight).ec == std::errc())
            return weight;
        if (end == std::string_view::npos) break;
        parameters.remove_prefix(end + 1);
    }
    return 1;
}

}  // namespace

std::string accepted_type(const RequestHead& head, const std::vector<std::string>& offered) {
    std::string accept;
    for (const auto& [name, value] : head.headers)
        if (name == "accept") accept += (accept.empty() ? "" : ",") + value;
    if (trimmed(accept).empty()) return offered.front();
    const std::string* best = nullptr;
    double best_weight = 0;
    for (const std::string& type : offered) {
        int closest = 0;
        double weight = 0;
        for (std::string_view rest = accept; !rest.empty();) {
            const size_t end = rest.find(',');
            const std::string_view one = rest.substr(0, end);
            const size_t parameters = one.find(';');
            const int close = closeness(trimmed(one.substr(0, parameters)), type);
            if (close > closest) {
                closest = close;
                weight = weight_of(parameters == std::string_view::npos ? "" : one.substr(parameters + 1));
            }
            rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
        }
        if (weight > best_weight) best = &type, best_weight = weight;
    }
    if (best != nullptr) return *best;
    std::string list;
    for (const std::string& type : offered) list += (list.empty() ? "" : ", ") + type;
    throw Error(ErrorCode::NotAcceptable, "none of the types that Accept names is to be had here; there are: " + list);
}

}  // namespace photond::http
