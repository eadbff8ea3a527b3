#include "server/comparisons/verdict.h"

#include <algorithm>

#include "protocol/enumerated.h"
#include "server/comparisons/left_out_marks.h"
#include "server/comparisons/report_text.h"

namespace photond {
namespace {

using nlohmann::json;

Interval span_of(const SeedMean& mean) { return {mean.low.value_or(mean.mean), mean.high.value_or(mean.mean)}; }

/// Where a row's time may lie: by its seeds, else by the references' noise. It reaches the error.
Interval span_of(const TimeToError& time) {
    if (!time.seconds->low && time.earliest && time.latest) return {*time.earliest, *time.latest};
    return span_of(*time.seconds);
}

bool overlap(const Interval& a, const Interval& b) { return a.greatest >= b.least && b.greatest >= a.least; }

/// Whether what a row's disturbed jobs lost is enough for it to have been there as soon as the one that was first.
bool might_be_first(const TimeToError& row, const TimeToError& first) {
    return row.undisturbed &&
           (row.undisturbed->mean <= first.seconds->mean || overlap(span_of(*row.undisturbed), span_of(first)));
}

/// Whether a row that does not reach the error by its upper ends may have been there by then all the same.
bool is_open(const TimeToError& row, const TimeToError& first) {
    return !row.seconds && row.earliest && *row.earliest <= span_of(first).greatest;
}

/// The least that a row comes to by a metric, where that is more than `error`.
std::optional<double> least_above(const TableRow& row, const std::string& metric, double error) {
    const auto least = floor_of(row, metric);
    return least && *least > error ? least : std::nullopt;
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
    for (const size_t r : std::span(verdict.arrived).subspan(1))
        if (!can_be_told_apart(first, at(r))) verdict.rivals.push_back(r);
    for (size_t r = 0; r < table.rows.size(); ++r) {
        if (r != verdict.arrived[0] && might_be_first(at(r), first)) verdict.doubtful.push_back(r);
        if (is_open(at(r), first) && !least_above(table.rows[r], metric, verdict.error)) verdict.open.push_back(r);
    }
    verdict.close = !verdict.rivals.empty() || !verdict.doubtful.empty() || !verdict.open.empty();
    return verdict;
}

/// The same rows are named first; where a second is there, by how much is told.
bool same_outcome(const Verdict& a, const Verdict& b) {
    if (a.close != b.close || (a.arrived.size() > 1) != (b.arrived.size() > 1)) return false;
    return a.arrived[0] == b.arrived[0] && a.rivals == b.rivals && a.doubtful == b.doubtful && a.open == b.open;
}

std::string name_of(const ComparisonTable& table, size_t row) {
    return row_name(table.rows[row].label, table.rows[row].parameters);
}

bool is_among(const std::vector<size_t>& rows, size_t row) {
    return std::find(rows.begin(), rows.end(), row) != rows.end();
}

/// "; not in its time: b; c reaches no less than relative_mse 0.02; the references' noise leaves open whether d was
/// there sooner"
std::string missing_text(const ComparisonTable& table, const Verdict& verdict) {
    std::string late, floors;
    std::vector<std::string> open;
    for (const size_t row : verdict.missing) {
        const std::string name = name_of(table, row);
        if (const auto least = least_above(table.rows[row], verdict.metric, verdict.error))
            floors += "; " + name + " reaches no less than " + verdict.metric + " " + short_number(*least);
        else if (is_among(verdict.open, row))
            open.push_back(name);
        else
            late += (late.empty() ? "" : ", ") + name;
    }
    if (!late.empty()) late.insert(0, "; not in its time: ");
    if (open.empty()) return late + floors;
    return late + floors + "; the references' noise leaves open whether " + enumerated(open) +
           (open.size() > 1 ? " were" : " was") + " there sooner";
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
        std::string& names = is_among(verdict.doubtful, row) ? doubtful : harmless;
        names += (names.empty() ? "" : ", ") + name_of(table, row);
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
    return !overlap(span_of(a), span_of(b)) && !(a.at_most && b.at_most) &&
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
    const auto named = [&](size_t row) {
        return name_of(table, row) + " (" + time_text(verdict.time(table, row)) + ")";
    };
    const std::string goal = verdict.metric + " " + exact_number(verdict.error);
    const size_t first_row = verdict.arrived[0];
    std::vector<size_t> said{first_row};
    std::string text, others;
    if (verdict.close) {
        std::vector<std::string> names{named(first_row)};
        said.insert(said.end(), verdict.rivals.begin(), verdict.rivals.end());
        for (const size_t row : std::span(said).subspan(1)) names.push_back(named(row));
        text = "too close to call at " + goal + ": " + enumerated(names);
    } else {
        const TimeToError& first = verdict.time(table, first_row);
        text = name_of(table, first_row) + " reaches " + goal + " first, after " + time_text(first);
        if (verdict.arrived.size() > 1) {
            said.push_back(verdict.arrived[1]);
            text += std::string(": ") + (first.at_most ? "at least " : "") +
                    short_number(verdict.seconds(table, said[1]) / first.seconds->mean) + " times sooner than " +
                    named(said[1]);
        }
    }
    for (const size_t row : verdict.arrived)
        if (!is_among(said, row)) others += (others.empty() ? "" : ", ") + named(row);
    if (!others.empty()) text += "; then " + others;
    text += missing_text(table, verdict);
    text += disturbance_text(table, verdict);
    text += marked_text(table, verdict.metric);
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
