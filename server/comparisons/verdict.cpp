#include "server/comparisons/verdict.h"

#include <algorithm>

#include "server/comparisons/report_text.h"

namespace photond {
namespace {

using nlohmann::json;

bool overlap(const LogMean& a, const LogMean& b) {
    return a.low && a.high && b.low && b.high && *a.high >= *b.low && *b.high >= *a.low;
}

/// Whether what a row's disturbed jobs lost is enough for it to have been there as soon as the one that was first.
bool might_be_first(const TimeToError& row, const TimeToError& first) {
    return row.earliest && (row.earliest->mean <= first.seconds->mean || overlap(*row.earliest, *first.seconds));
}

/// Of the level at this index; without a row that arrives where there is none.
Verdict verdict_at(const ComparisonTable& table, const std::string& metric, size_t level) {
    const auto at = [&](size_t r) -> const TimeToError& { return table.rows[r].time_to_error.at(metric)[level]; };
    Verdict verdict;
    verdict.metric = metric;
    verdict.error = verdict.easiest = at(0).error;
    for (size_t r = 0; r < table.rows.size(); ++r) (at(r).seconds ? verdict.arrived : verdict.missing).push_back(r);
    std::stable_sort(verdict.arrived.begin(), verdict.arrived.end(),
                     [&](size_t a, size_t b) { return at(a).seconds->mean < at(b).seconds->mean; });
    if (verdict.arrived.empty()) return verdict;
    const TimeToError& first = at(verdict.arrived[0]);
    verdict.close = verdict.arrived.size() > 1 && !can_be_told_apart(first, at(verdict.arrived[1]));
    for (size_t r = 0; r < table.rows.size(); ++r)
        if (r != verdict.arrived[0] && might_be_first(at(r), first)) verdict.doubtful.push_back(r);
    verdict.close = verdict.close || !verdict.doubtful.empty();
    return verdict;
}

/// The same rows are named first; where a second is there, by how much is told.
bool same_outcome(const Verdict& a, const Verdict& b) {
    if (a.close != b.close || (a.arrived.size() > 1) != (b.arrived.size() > 1)) return false;
    if (a.arrived[0] != b.arrived[0] || a.doubtful != b.doubtful) return false;
    return !a.close || a.arrived.size() == 1 || a.arrived[1] == b.arrived[1];
}

std::vector<size_t> disturbed_rows(const ComparisonTable& table) {
    std::vector<size_t> rows;
    for (size_t row = 0; row < table.rows.size(); ++row)
        if (table.rows[row].disturbed > 0) rows.push_back(row);
    return rows;
}

/// "; b lost processor time to other processes and might have been first"; empty where nobody did.
std::string disturbance_text(const ComparisonTable& table, const Verdict& verdict) {
    std::string doubtful, harmless;
    for (const size_t row : disturbed_rows(table)) {
        const bool in_doubt =
            std::find(verdict.doubtful.begin(), verdict.doubtful.end(), row) != verdict.doubtful.end();
        std::string& names = in_doubt ? doubtful : harmless;
        names += (names.empty() ? "" : ", ") + row_name(table.rows[row].label, table.rows[row].parameters);
    }
    std::string text;
    if (!doubtful.empty())
        text += "; " + doubtful + " lost processor time to other processes and might have been first";
    if (!harmless.empty() && doubtful.empty())
        text += "; " + harmless + " lost processor time to other processes, which changes nothing here";
    return text;
}

std::string time_text(const TimeToError& time) {
    return (time.at_most ? "at most " : "") + short_seconds(time.seconds->mean);
}

}  // namespace

const TimeToError& Verdict::time(const ComparisonTable& table, size_t row) const {
    const std::vector<TimeToError>& levels = table.rows[row].time_to_error.at(metric);
    return *std::find_if(levels.begin(), levels.end(), [&](const TimeToError& level) { return level.error == error; });
}

bool can_be_told_apart(const TimeToError& a, const TimeToError& b) {
    const bool in_order = a.seconds->mean < b.seconds->mean;
    return a.seconds->mean != b.seconds->mean && !overlap(*a.seconds, *b.seconds) && !(a.at_most && b.at_most) &&
           !might_be_first(in_order ? b : a, in_order ? a : b);
}

std::vector<Verdict> verdicts(const ComparisonTable& table) {
    std::vector<Verdict> found;
    if (table.rows.size() < 2) return found;
    for (const std::string& metric : table.metrics) {
        const size_t first = found.size();
        // The levels are the same in every row, the largest first.
        for (size_t level = 0; level < table.rows.front().time_to_error.at(metric).size(); ++level) {
            Verdict verdict = verdict_at(table, metric, level);
            if (verdict.arrived.empty()) continue;
            if (found.size() > first && same_outcome(found.back(), verdict)) {
                verdict.easiest = found.back().easiest;
                found.back() = std::move(verdict);
            } else {
                found.push_back(std::move(verdict));
            }
        }
    }
    return found;
}

std::string verdict_text(const ComparisonTable& table, const Verdict& verdict) {
    const auto name = [&](size_t row) { return row_name(table.rows[row].label, table.rows[row].parameters); };
    const auto named = [&](size_t row) { return name(row) + " (" + time_text(verdict.time(table, row)) + ")"; };
    const std::string goal = verdict.metric + " " + exact_number(verdict.error);
    std::string text, others;
    if (verdict.close) {
        text = "too close to call at " + goal + ": " + named(verdict.arrived[0]);
        if (verdict.arrived.size() > 1) text += " and " + named(verdict.arrived[1]);
    } else {
        const TimeToError& first = verdict.time(table, verdict.arrived[0]);
        text = name(verdict.arrived[0]) + " reaches " + goal + " first, after " + time_text(first);
        if (verdict.arrived.size() > 1)
            text += std::string(": ") + (first.at_most ? "at least " : "") +
                    short_number(verdict.seconds(table, verdict.arrived[1]) / first.seconds->mean) +
                    " times sooner than " + named(verdict.arrived[1]);
    }
    for (size_t i = 2; i < verdict.arrived.size(); ++i)
        others += (others.empty() ? "" : ", ") + named(verdict.arrived[i]);
    if (!others.empty()) text += "; then " + others;
    std::string missing;
    for (const size_t row : verdict.missing) missing += (missing.empty() ? "" : ", ") + name(row);
    if (!missing.empty()) text += "; not in its time: " + missing;
    text += disturbance_text(table, verdict);
    if (verdict.easiest > verdict.error) text += "; likewise from " + exact_number(verdict.easiest) + " on";
    return text;
}

json verdicts_json(const ComparisonTable& table, std::span<const Verdict> verdicts) {
    json list = json::array();
    for (const Verdict& verdict : verdicts) {
        json arrived = json::array();
        for (const size_t row : verdict.arrived)
            arrived.push_back({{"row", row}, {"seconds", verdict.seconds(table, row)}});
        const bool two = verdict.arrived.size() > 1;
        list.push_back({{"metric", verdict.metric},
                        {"error", verdict.error},
                        {"easiest", verdict.easiest},
                        {"close", verdict.close},
                        {"factor", two ? json(verdict.seconds(table, verdict.arrived[1]) /
                                              verdict.seconds(table, verdict.arrived[0]))
                                       : json()},
                        {"arrived", std::move(arrived)},
                        {"missing", verdict.missing},
                        {"disturbed", disturbed_rows(table)},
                        {"text", verdict_text(table, verdict)}});
    }
    return list;
}

}  // namespace photond
