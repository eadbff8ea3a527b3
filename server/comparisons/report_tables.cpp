#include "server/comparisons/report_tables.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "server/comparisons/plot.h"
#include "server/comparisons/report_html.h"
#include "server/comparisons/report_text.h"

namespace photond {
namespace {

std::string name_of(const TableRow& row) { return escaped(row_name(row.label, row.parameters)); }

/// The legend's stroke and the row's name.
std::string row_head(const ComparisonTable& table, size_t r) {
    return "<td>" + legend_stroke(r) + name_of(table.rows[r]) + "</td>";
}

std::string head(const std::vector<std::string>& columns) {
    std::string html = "<thead><tr>";
    for (const std::string& column : columns) html += "<th>" + column + "</th>";
    return html + "</tr></thead>";
}

std::string with_interval(const LogMean& mean, std::string (*written)(double)) {
    const std::string spread = interval(mean, written);
    return written(mean.mean) + (spread.empty() ? "" : "<small>" + spread + "</small>");
}

/// A cell of what not every seed reached.
std::string missing(size_t reached, size_t seeds, const char* what) {
    return "<td class=\"soft\" title=\"" + std::to_string(reached) + " of " + std::to_string(seeds) + " seeds " + what +
           "\">–</td>";
}

/// A table of one figure for each row and column; the smallest of each column is marked.
struct Figures {
    std::vector<std::string> columns;
    std::string (*written)(double);
    const char* reaching;  // "reached it"
    std::function<const std::optional<LogMean>&(size_t row, size_t column)> mean;
    std::function<size_t(size_t row, size_t column)> reached;
    std::function<bool(size_t row, size_t column)> at_most = [](size_t, size_t) { return false; };
};

std::string figures_table(const ComparisonTable& table, const Figures& figures, const std::string& caption) {
    std::vector<std::string> columns{""};
    columns.insert(columns.end(), figures.columns.begin(), figures.columns.end());
    std::string html = "<div class=\"scroll\"><table><caption>" + caption + "</caption>" + head(columns) + "<tbody>";
    std::vector<double> best(figures.columns.size(), std::numeric_limits<double>::infinity());
    for (size_t r = 0; r < table.rows.size(); ++r)
        for (size_t c = 0; c < best.size(); ++c)
            if (const auto& mean = figures.mean(r, c)) best[c] = std::min(best[c], mean->mean);
    for (size_t r = 0; r < table.rows.size(); ++r) {
        html += "<tr>" + row_head(table, r);
        for (size_t c = 0; c < best.size(); ++c) {
            const auto& mean = figures.mean(r, c);
            if (!mean) {
                html += missing(figures.reached(r, c), table.rows[r].seeds, figures.reaching);
                continue;
            }
            const bool marked = mean->mean == best[c] && table.rows.size() > 1;
            html += std::string(marked ? "<td class=\"best\">" : "<td>") + (figures.at_most(r, c) ? "≤ " : "") +
                    with_interval(*mean, figures.written) + "</td>";
        }
        html += "</tr>";
    }
    return html + "</tbody></table></div>";
}

std::string spread_text(const Spread& spread, std::string (*written)(double)) {
    return spread.min == spread.max ? written(spread.min) : written(spread.min) + " – " + written(spread.max);
}

std::string whole(double value) {
    const std::string digits = std::to_string(static_cast<uint64_t>(value));
    std::string text;
    for (size_t i = 0; i < digits.size(); ++i) {
        if (i > 0 && (digits.size() - i) % 3 == 0) text += ",";
        text += digits[i];
    }
    return text;
}

std::string cell(const std::optional<Spread>& spread, std::string (*written)(double)) {
    return spread ? "<td>" + spread_text(*spread, written) + "</td>" : "<td class=\"soft\">–</td>";
}

std::string error_cell(const FinalError& figure) {
    if (!figure.error) return "<td class=\"soft\">–</td>";
    std::string html = "<td>" + with_interval(*figure.error, short_number);
    if (figure.reference)
        html += std::string("<small") + (figure.near_reference ? " class=\"warning\"" : "") + ">reference " +
                short_number(*figure.reference) + (figure.near_reference ? " (!)" : "") + "</small>";
    return html + "</td>";
}

}  // namespace

std::string time_to_error_table(const ComparisonTable& table, const std::string& metric) {
    if (table.rows.empty() || table.rows.front().time_to_error.at(metric).empty()) return "";
    Figures figures{{}, short_seconds, "reached it", {}, {}};
    for (const TimeToError& level : table.rows.front().time_to_error.at(metric))
        figures.columns.push_back(short_number(level.error));
    figures.mean = [&](size_t r, size_t c) -> const std::optional<LogMean>& {
        return table.rows[r].time_to_error.at(metric)[c].seconds;
    };
    figures.reached = [&](size_t r, size_t c) { return table.rows[r].time_to_error.at(metric)[c].reached; };
    figures.at_most = [&](size_t r, size_t c) { return table.rows[r].time_to_error.at(metric)[c].at_most; };
    return figures_table(table, figures,
                         "Time to reach an error of ... and stay there; small: 95 % interval over the seeds; – : not "
                         "reached by every seed; ≤ : below it from the first measurement on.");
}

std::string error_at_time_table(const ComparisonTable& table, const std::string& metric) {
    if (table.rows.empty() || table.rows.front().error_at_time.at(metric).empty()) return "";
    Figures figures{{}, short_number, "have a curve there", {}, {}};
    for (const ErrorAtTime& time : table.rows.front().error_at_time.at(metric))
        figures.columns.push_back(short_seconds(time.seconds));
    figures.mean = [&](size_t r, size_t c) -> const std::optional<LogMean>& {
        return table.rows[r].error_at_time.at(metric)[c].error;
    };
    figures.reached = [&](size_t r, size_t c) { return table.rows[r].error_at_time.at(metric)[c].reached; };
    return figures_table(table, figures, "Error after ... ; – : outside the curve of some seed.");
}

std::string cost_table(const ComparisonTable& table) {
    std::vector<std::string> columns{"", "seeds", "passes", "photons", "seconds"};
    for (const std::string& metric : table.metrics) columns.push_back(escaped(metric));
    for (const char* column : {"peak memory", "efficiency", "Pareto front"}) columns.emplace_back(column);
    std::string html =
        "<div class=\"scroll\"><table><caption>At the end of each job. Seconds: from the quickest to the slowest seed. "
        "Memory: the largest seed's, beside the idle process. Efficiency: 1 / (mean squared error × seconds)."
        "</caption>" +
        head(columns) + "<tbody>";
    for (size_t r = 0; r < table.rows.size(); ++r) {
        const TableRow& row = table.rows[r];
        html += "<tr>" + row_head(table, r) + "<td>" +
                (row.succeeded == row.seeds ? std::to_string(row.seeds)
                                            : std::to_string(row.succeeded) + " of " + std::to_string(row.seeds)) +
                "</td>" + cell(row.passes, whole) + cell(row.photons, whole) + cell(row.seconds, short_seconds);
        for (const std::string& metric : table.metrics) html += error_cell(row.error.at(metric));
        html += "<td>" + (row.peak_bytes ? short_bytes(*row.peak_bytes) : "–") + "</td><td>" +
                (row.efficiency ? short_number(*row.efficiency) : "–") + "</td><td>" + (row.pareto ? "yes" : "no") +
                "</td></tr>";
    }
    return html + "</tbody></table></div>";
}

}  // namespace photond
