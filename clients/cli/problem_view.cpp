#include "clients/cli/problem_view.h"

#include "clients/cli/json_member.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

std::string fault_text(const json& fault) {
    const std::string pointer = plain_text(member(fault, "pointer"));
    return (pointer.empty() || pointer == "-" ? "" : pointer + ": ") + plain_text(member(fault, "detail"));
}

}  // namespace

void remark_problem(const Session& session, const std::string& before, const std::string& headline,
                    const json& problem) {
    const json errors = member(problem, "errors");
    const size_t count = errors.is_array() ? errors.size() : 0;
    const std::string detail = plain_text(member(problem, "detail"));
    if (count != 1) {
        session.remark(before + headline);
        for (size_t i = 0; i < count; ++i) session.remark("  " + fault_text(errors[i]));
        return;
    }
    // The detail of a single fault is that fault, with its place or without.
    const size_t begin = headline.rfind(detail);
    const bool repeats = detail.ends_with(plain_text(member(errors[0], "detail"))) && begin != std::string::npos &&
                         begin + detail.size() == headline.size();
    session.remark(before + (repeats ? headline.substr(0, begin) : headline + ": ") + fault_text(errors[0]));
}

}  // namespace photond::cli
