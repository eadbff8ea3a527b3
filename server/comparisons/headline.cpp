#include "server/comparisons/headline.h"

#include <algorithm>
#include <cassert>

#include "server/comparisons/left_out_marks.h"
#include "server/comparisons/report_text.h"

namespace photond {
namespace {

using nlohmann::json;

constexpr size_t kMostStretches = 5;  // that a sentence tells one by one

/// The row that a verdict says is first.
std::optional<size_t> first_row(const Verdict& verdict) {
    return verdict.close ? std::nullopt : std::optional(verdict.arrived.front());
}

/// Of a row that reaches what any row does: whether no other is sooner at any level, as far as they can be told apart.
bool is_never_behind(const ComparisonTable& table, const std::string& metric, size_t row) {
    const std::vector<TimeToError>& own = table.rows[row].time_to_error.at(metric);
    for (const TableRow& other_row : table.rows) {
        const std::vector<TimeToError>& other = other_row.time_to_error.at(metric);
        for (size_t level = 0; level < own.size(); ++level) {
            if (!other[level].seconds) continue;
            assert(own[level].seconds && "who is first at the smallest error has reached every larger one");
            if (other[level].seconds->mean < own[level].seconds->mean && can_be_told_apart(own[level], other[level]))
                return false;
        }
    }
    return true;
}

/// Which of the verdicts [begin, end) goes with a sentence about `row`.
size_t verdict_beside(std::span<const Verdict> verdicts, size_t begin, size_t end, std::optional<size_t> row) {
    std::optional<size_t> of_two, of_any;
    for (size_t i = begin; i < end; ++i) {
        if (row && first_row(verdicts[i]) != row) continue;
        of_any = i;
        if (verdicts[i].arrived.size() > 1) of_two = i;
    }
    return of_two ? *of_two : *of_any;
}

/// Of the verdicts [begin, end), which are all of one metric.
Headline headline_of(const ComparisonTable& table, std::span<const Verdict> verdicts, size_t begin, size_t end) {
    Headline headline;
    headline.metric = verdicts[begin].metric;
    for (const Verdict& verdict : verdicts.subspan(begin, end - begin)) {
        const std::optional<size_t> first = first_row(verdict);
        if (headline.stretches.empty() || headline.stretches.back().row != first)
            headline.stretches.push_back({first, verdict.easiest, verdict.error});
        else
            headline.stretches.back().error = verdict.error;
    }
    const std::vector<size_t> leaders = headline.leaders();
    const std::optional<size_t> last = headline.stretches.back().row;
    headline.row = leaders.size() == 1 ? leaders.front() : last;
    headline.best = last && leaders.size() == 1 && is_never_behind(table, headline.metric, *last);
    headline.verdict = verdict_beside(verdicts, begin, end, headline.row);
    return headline;
}

/// "paths is first down to relative_mse 0.2, photons below that".
std::string stretches_text(const Headline& headline, const std::vector<std::string>& names) {
    std::string text;
    bool first_is_said = false;  // "is first", by the clause before
    for (size_t i = 0; i < headline.stretches.size(); ++i) {
        const Stretch& stretch = headline.stretches[i];
        if (i > 0) text += stretch.row && first_is_said ? ", " : "; ";
        if (stretch.row)
            text += names[*stretch.row] + (first_is_said ? "" : " is first");
        else
            text += "it is too close to call";
        first_is_said = stretch.row.has_value();
        if (i + 1 == headline.stretches.size())
            text += " below that";
        else
            text += " down to " + (i == 0 ? headline.metric + " " : "") + exact_number(stretch.error);
    }
    return text;
}

/// "the lead changes 6 times; photons is first below relative_mse 0.02", where there are too many to tell each.
std::string changes_text(const Headline& headline, const std::vector<std::string>& names) {
    size_t changes = 0;
    std::optional<size_t> leader;
    for (const Stretch& stretch : headline.stretches) {
        if (!stretch.row) continue;
        changes += leader && leader != stretch.row;
        leader = stretch.row;
    }
    const Stretch &before = *(headline.stretches.end() - 2), &last = headline.stretches.back();
    return "the lead changes " + std::to_string(changes) + (changes == 1 ? " time; " : " times; ") +
           (last.row ? names[*last.row] + " is first" : "it is too close to call") + " below " + headline.metric + " " +
           exact_number(before.error);
}

/// Who is first, where.
std::string outcome_text(const ComparisonTable& table, const Headline& headline) {
    std::vector<std::string> names;
    for (const TableRow& row : table.rows) names.push_back(row_name(row.label, row.parameters));
    const std::vector<size_t> leaders = headline.leaders();
    const bool many = headline.stretches.size() > kMostStretches;
    if (leaders.empty()) return "Too close to call";
    if (headline.best) return names[*headline.row] + " is better here";
    if (leaders.size() > 1)
        return "It depends on the error you need: " +
               (many ? changes_text(headline, names) : stretches_text(headline, names));
    if (many) return names[*headline.row] + " is first wherever it is not too close to call";
    std::string text = stretches_text(headline, names);
    if (!headline.stretches.front().row) text.front() = 'I';  // "it is too close"
    return text;
}

}  // namespace

std::vector<size_t> Headline::leaders() const {
    std::vector<size_t> found;
    for (const Stretch& stretch : stretches)
        if (stretch.row && std::find(found.begin(), found.end(), *stretch.row) == found.end())
            found.push_back(*stretch.row);
    return found;
}

std::vector<Headline> headlines(const ComparisonTable& table, std::span<const Verdict> verdicts) {
    std::vector<Headline> found;
    for (size_t begin = 0, end = 0; begin < verdicts.size(); begin = end) {
        while (end < verdicts.size() && verdicts[end].metric == verdicts[begin].metric) ++end;
        found.push_back(headline_of(table, verdicts, begin, end));
    }
    return found;
}

std::string headline_text(const ComparisonTable& table, const Headline& headline) {
    return outcome_text(table, headline) + lacking_reference_text(table, headline.metric);
}

json headlines_json(const ComparisonTable& table, std::span<const Verdict> verdicts) {
    const auto index_json = [](std::optional<size_t> row) { return row ? json(*row) : json(); };
    json list = json::array();
    for (const Headline& headline : headlines(table, verdicts)) {
        json stretches = json::array();
        for (const Stretch& stretch : headline.stretches)
            stretches.push_back(
                {{"row", index_json(stretch.row)}, {"easiest", stretch.easiest}, {"error", stretch.error}});
        list.push_back({{"metric", headline.metric},
                        {"text", headline_text(table, headline)},
                        {"row", index_json(headline.row)},
                        {"best", headline.best},
                        {"verdict", headline.verdict},
                        {"stretches", std::move(stretches)}});
    }
    return list;
}

}  // namespace photond
