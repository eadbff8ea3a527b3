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

std::string small(const std::string& text) { return text.empty() ? "" : "<small>" + text + "</small>"; }

/// A cell of what not every seed reached.
std::string missing(size_t reached, size_t seeds, const char* what) {
    return "<td class=\"soft\" title=\"" + std::to_string(reached) + " of " + std::to_string(seeds) + " seeds " + what +
           "\">–</td>";
}

/// What a cell shows, and by what the smallest of its column is found, which is marked.
struct Figure {
    double value;
    std::string html;
};

std::string error_text(const MeanError& mean) {
    if (!mean.is_bound()) return short_number(mean.error.mean);
    const auto bound = mean.drawn();
    return bound ? "&lt; " + short_number(*bound) : short_number(mean.error.mean);
}

/// The error, beneath it its interval over the seeds, beneath that what the references' noise leaves open.
std::string error_html(const MeanError& mean) {
    std::string html = error_text(mean) + small(interval(mean.error, short_number));
    if (mean.interval) html += small("ref. " + range(mean.interval->least, mean.interval->greatest, short_number));
    return html;
}

/// The time, beneath it its interval over the seeds; of one seed what the references' noise leaves open.
std::string time_html(const TimeToError& time) {
    std::string html = (time.at_most ? "≤ " : "") + short_seconds(time.seconds->mean);
    if (time.seconds->low) return html + small(interval(*time.seconds, short_seconds));
    if (!time.earliest || !time.latest || short_seconds(*time.earliest) == short_seconds(*time.latest)) return html;
    return html + small("ref. " + range(*time.earliest, *time.latest, short_seconds));
}

/// A table of one figure for each row and column.
struct Figures {
    std::vector<std::string> columns;
    const char* reaching;  // "reached it"
    std::function<std::optional<Figure>(size_t row, size_t column)> figure;
    std::function<size_t(size_t row, size_t column)> reached;
};

std::string figures_table(const ComparisonTable& table, const Figures& figures, const std::string& caption) {
    std::vector<std::string> columns{""};
    columns.insert(columns.end(), figures.columns.begin(), figures.columns.end());
    std::string html = "<div class=\"scroll\"><table><caption>" + caption + "</caption>" + head(columns) + "<tbody>";
    std::vector<double> best(figures.columns.size(), std::numeric_limits<double>::infinity());
    for (size_t r = 0; r < table.rows.size(); ++r)
        for (size_t c = 0; c < best.size(); ++c)
            if (const auto figure = figures.figure(r, c)) best[c] = std::min(best[c], figure->value);
    for (size_t r = 0; r < table.rows.size(); ++r) {
        html += "<tr>" + row_head(table, r);
        for (size_t c = 0; c < best.size(); ++c) {
            const auto figure = figures.figure(r, c);
            if (!figure) {
                html += missing(figures.reached(r, c), table.rows[r].seeds, figures.reaching);
                continue;
            }
            const bool marked = figure->value == best[c] && table.rows.size() > 1;
            html += std::string(marked ? "<td class=\"best\">" : "<td>") + figure->html + "</td>";
        }
        html += "</tr>";
    }
    return html + "</tbody></table></div>";
}

std::string spread_text(const Spread& spread, std::string (*written)(double)) {
    return spread.min == spread.max ? written(spread.min) : range(spread.min, spread.max, written);
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
    if (!figure.mean) return "<td class=\"soft\">–</td>";
    std::string html = "<td>" + error_html(*figure.mean);
    const bool has_noise = figure.reference && !figure.mean->interval;  // else it is in the interval
    if (has_noise || figure.near_reference)
        html += std::string("<small") + (figure.near_reference ? " class=\"warning\"" : "") + ">" +
                (has_noise ? "reference " + short_number(*figure.reference) : "not known to a third") +
                (figure.near_reference ? " (!)" : "") + "</small>";
    return html + "</td>";
}

}  // namespace

std::string time_to_error_table(const ComparisonTable& table, const std::string& metric) {
    if (table.rows.empty() || table.rows.front().time_to_error.at(metric).empty()) return "";
    const auto at = [&](size_t r, size_t c) -> const TimeToError& { return table.rows[r].time_to_error.at(metric)[c]; };
    Figures figures{{}, "reached it", {}, {}};
    for (const TimeToError& level : table.rows.front().time_to_error.at(metric))
        figures.columns.push_back(short_number(level.error));
    figures.figure = [&](size_t r, size_t c) -> std::optional<Figure> {
        if (!at(r, c).seconds) return std::nullopt;
        return Figure{at(r, c).seconds->mean, time_html(at(r, c))};
    };
    figures.reached = [&](size_t r, size_t c) { return at(r, c).reached; };
    return figures_table(table, figures,
                         "Time to reach an error of ... , at two points after each other, by its upper end; small: 95 "
                         "% interval over the seeds, or (ref.) what the references' noise leaves open; – : not reached "
                         "by every seed; ≤ : below it from the first measurement on.");
}

std::string error_at_time_table(const ComparisonTable& table, const std::string& metric) {
    if (table.rows.empty() || table.rows.front().error_at_time.at(metric).empty()) return "";
    const auto at = [&](size_t r, size_t c) -> const ErrorAtTime& { return table.rows[r].error_at_time.at(metric)[c]; };
    Figures figures{{}, "have a curve there", {}, {}};
    for (const ErrorAtTime& time : table.rows.front().error_at_time.at(metric))
        figures.columns.push_back(short_seconds(time.seconds));
    figures.figure = [&](size_t r, size_t c) -> std::optional<Figure> {
        if (!at(r, c).mean) return std::nullopt;
        return Figure{at(r, c).mean->upper_end(), error_html(*at(r, c).mean)};
    };
    figures.reached = [&](size_t r, size_t c) { return at(r, c).reached; };
    return figures_table(table, figures,
                         "Error after ... ; small: 95 % interval over the seeds, and (ref.) what the references' noise "
                         "leaves open, at 90 %; &lt; : not told apart from 0; – : outside the curve of some seed; the "
                         "lowest, by its upper end, is marked.");
}

std::string cost_table(const ComparisonTable& table) {
    std::vector<std::string> columns{"", "seeds", "passes", "photons", "seconds"};
    for (const std::string& metric : table.metrics) columns.push_back(escaped(metric));
    for (const char* column : {"peak memory", "efficiency", "Pareto front"}) columns.emplace_back(column);
    std::string html =
        "<div class=\"scroll\"><table><caption>At the end of each job. Seconds: from the quickest to the slowest seed. "
        "Memory: the largest seed's, beside the idle process. Efficiency: 1 / (mean squared error × seconds), – where "
        "that error is not told apart from 0."
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
