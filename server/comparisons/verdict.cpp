#include "server/comparisons/verdict.h"

#include <algorithm>

#include "server/comparisons/report_text.h"

namespace photond {
namespace {

using nlohmann::json;

bool overlap(const LogMean& a, const LogMean& b) {
    return a.low && a.high && b.low && b.high && *a.high >= *b.low && *b.high >= *a.low;
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
    if (verdict.arrived.size() > 1) {
        const TimeToError &first = at(verdict.arrived[0]), &second = at(verdict.arrived[1]);
        verdict.close = !can_be_told_apart(first, second);
    }
    return verdict;
}

/// The same rows are named first; where a second is there, by how much is told.
bool same_outcome(const Verdict& a, const Verdict& b) {
    if (a.close != b.close || (a.arrived.size() > 1) != (b.arrived.size() > 1)) return false;
    return a.arrived[0] == b.arrived[0] && (!a.close || a.arrived[1] == b.arrived[1]);
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
    return a.seconds->mean != b.seconds->mean && !overlap(*a.seconds, *b.seconds) && !(a.at_most && b.at_most);
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
        text = "too close to call at " + goal + ": " + named(verdict.arrived[0]) + " and " + named(verdict.arrived[1]);
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
                        {"text", verdict_text(table, verdict)}});
    }
    return list;
}

}  // namespace photond
