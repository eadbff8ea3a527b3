#include "clients/cli/comparison_view.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <ostream>
#include <set>
#include <utility>
#include <vector>

#include "clients/cli/job_follower.h"
#include "clients/cli/json_member.h"
#include "clients/cli/text_table.h"
#include "clients/cli/units.h"

namespace photond::cli {

using nlohmann::json;

namespace {

constexpr size_t kMostRowsAcross = 4;  // more are written down the page
constexpr size_t kMostColumns = 6;     // of places then

using Format = std::function<std::string(double)>;

/// A figure and where it lies: by its seeds or, of one seed, by the references' noise.
struct Figure {
    double value = 0;
    std::optional<std::pair<double, double>> between;
    std::optional<double> at_most;  // of an error that is not positive: its upper bound

    std::string text(const Format& format) const { return at_most ? "< " + format(*at_most) : format(value); }
    std::string text_with_interval(const Format& format) const {
        if (!between || at_most) return text(format);
        const std::string from = format(between->first), to = format(between->second);
        return from == to ? text(format) : format(value) + " (" + from + " to " + to + ")";
    }
};

std::optional<std::pair<double, double>> pair_of(const json& from, const json& to) {
    if (!from.is_number() || !to.is_number()) return std::nullopt;
    return std::pair(from.get<double>(), to.get<double>());
}

/// Of a mean as tables hold it: `value` is its member's name.
std::optional<Figure> figure_of(const json& mean, const char* value) {
    if (!member(mean, value).is_number()) return std::nullopt;
    Figure figure{mean[value].get<double>(), pair_of(member(mean, "low"), member(mean, "high")), {}};
    if (!figure.between) figure.between = pair_of(member(mean, "earliest"), member(mean, "latest"));
    const json ends = member(mean, "interval");
    if (!ends.is_array() || ends.size() != 2) return figure;
    const auto noise = pair_of(ends[0], ends[1]);
    if (!figure.between) figure.between = noise;
    // An interval that lies below 0 as a whole is too low by luck: half of its width is what an error of 0 would have.
    if (noise && figure.value <= 0)
        figure.at_most = noise->second > 0 ? noise->second : 0.5 * (noise->second - noise->first);
    return figure;
}

/// The metrics of the tables, in the order they were asked for.
std::vector<std::string> metrics_of(const json& comparison) {
    std::vector<std::string> metrics;
    for (const json& metric : member(member(comparison, "request"), "metrics")) metrics.push_back(plain_text(metric));
    return metrics;
}

/// One of the two kinds of table: `kind` is the member of a row, `at` what its columns are of, `value` what they hold.
struct Curve {
    const char* kind;
    const char* at;
    const char* value;
};
constexpr Curve kTimeToError{"time_to_error", "error", "seconds"};
constexpr Curve kErrorAtTime{"error_at_time", "seconds", "error"};

json points_of(const json& row, const Curve& curve, const std::string& metric) {
    const json points = member(member(row, curve.kind), metric.c_str());
    return points.is_array() ? points : json::array();
}

/// Where any row has a figure, rising.
std::set<double> places(const json& table, const Curve& curve, const std::string& metric) {
    std::set<double> found;
    for (const json& row : table)
        for (const json& point : points_of(row, curve, metric))
            if (member(point, curve.at).is_number() && member(point, curve.value).is_number())
                found.insert(point[curve.at].get<double>());
    return found;
}

std::optional<Figure> figure_at(const json& row, const Curve& curve, const std::string& metric, double place) {
    for (const json& point : points_of(row, curve, metric)) {
        if (!member(point, curve.at).is_number() || point[curve.at].get<double>() != place) continue;
        return figure_of(point, curve.value);
    }
    return std::nullopt;
}

/// What is asked of one metric of the table: where its figures are, and how places and figures are written.
struct CurveTable {
    const json& rows;
    const Curve& curve;
    const std::string& metric;
    Format place_text, figure_text;

    std::string cell_at(const json& row, double place) const {
        const std::optional<Figure> figure = figure_at(row, curve, metric, place);
        return figure ? figure->text_with_interval(figure_text) : "-";
    }
};

/// Places down, rows across: for few rows, with their intervals.
void print_places_down(std::ostream& out, const CurveTable& table, const std::string& title,
                       const std::vector<double>& places) {
    std::vector<TextTable::Column> heads{{title, Align::Right}};
    for (const json& row : table.rows) heads.push_back({comparison_row_name(row), Align::Right});
    TextTable text(heads);
    for (const double place : places) {
        std::vector<std::string> cells{table.place_text(place)};
        for (const json& row : table.rows) cells.push_back(table.cell_at(row, place));
        text.add_row(std::move(cells));
    }
    text.print(out << '\n', "  ");
}

/// Rows down, places across: for sweeps. Only so many places fit a line, without intervals; evenly chosen, the hardest
/// among them.
void print_rows_down(std::ostream& out, const CurveTable& table, const std::string& title,
                     const std::vector<double>& places) {
    std::vector<double> chosen;
    for (size_t i = std::min(places.size(), kMostColumns); i > 0; --i)
        chosen.push_back(places[places.size() - 1 - (i - 1) * places.size() / std::min(places.size(), kMostColumns)]);
    std::vector<TextTable::Column> heads{{title}};
    for (const double place : chosen) heads.push_back({table.place_text(place), Align::Right});
    TextTable text(heads);
    for (const json& row : table.rows) {
        std::vector<std::string> cells{comparison_row_name(row)};
        for (const double place : chosen) {
            const std::optional<Figure> figure = figure_at(row, table.curve, table.metric, place);
            cells.push_back(figure ? figure->text(table.figure_text) : "-");
        }
        text.add_row(std::move(cells));
    }
    text.print(out << '\n', "  ");
}

void print_curve(std::ostream& out, const CurveTable& table, const std::string& title,
                 const std::vector<double>& places) {
    if (places.empty()) return;
    if (table.rows.size() <= kMostRowsAcross)
        print_places_down(out, table, title, places);
    else
        print_rows_down(out, table, title, places);
}

/// What each row ended with and what it cost.
void print_ends(std::ostream& out, const json& rows, const std::vector<std::string>& metrics) {
    std::vector<TextTable::Column> heads{{"at the end"}, {"passes", Align::Right}};
    for (const std::string& metric : metrics) heads.push_back({metric, Align::Right});
    for (const char* head : {"peak memory", "efficiency"}) heads.push_back({head, Align::Right});
    heads.push_back({"Pareto front"});
    TextTable text(heads);
    for (const json& row : rows) {
        const json passes = member(row, "passes");
        std::vector<std::string> cells{comparison_row_name(row), plain_text(member(passes, "min"))};
        if (member(passes, "max") != member(passes, "min")) cells.back() += " to " + plain_text(passes["max"]);
        for (const std::string& metric : metrics) {
            const json error = member(member(row, "error"), metric.c_str());
            const std::optional<Figure> figure = figure_of(error, "value");
            const bool has_space = rows.size() <= kMostRowsAcross;
            cells.push_back(!figure     ? "-"
                            : has_space ? figure->text_with_interval(three_digit_number)
                                        : figure->text(three_digit_number));
            if (member(error, "near_reference") == true) cells.back() += "!";
        }
        const json bytes = member(row, "peak_bytes");
        const json efficiency = member(row, "efficiency");
        cells.push_back(bytes.is_number() ? human_bytes(bytes.get<double>()) : "-");
        cells.push_back(efficiency.is_number() ? three_digit_number(efficiency.get<double>()) : "-");
        cells.push_back(member(row, "pareto") == true ? "*" : "");
        text.add_row(std::move(cells));
    }
    text.print(out << '\n', "  ");
}

/// The reference's own noise, or that it is in the intervals, and what it spoils.
void print_noise(std::ostream& out, const json& rows, const std::vector<std::string>& metrics) {
    for (const std::string& metric : metrics) {
        std::optional<double> noise;
        bool crossed = false;
        std::string spoilt;
        for (const json& row : rows) {
            const json error = member(member(row, "error"), metric.c_str());
            if (member(error, "reference").is_number()) noise = error["reference"].get<double>();
            crossed = crossed || member(error, "interval").is_array();
            if (member(error, "near_reference") == true)
                spoilt += (spoilt.empty() ? "" : "; ") + comparison_row_name(row);
        }
        if (crossed)
            out << "  " << metric << " is free of the references' noise; what is left of it is in the intervals of one "
                << "seed, at 90 %\n";
        else if (noise)
            out << "  the reference's own noise: " << metric << ' ' << three_digit_number(*noise) << '\n';
        if (!spoilt.empty())
            out << (crossed ? "  ! not known to a third of itself, by the references' noise: "
                            : "  ! within three times that noise, which then is part of the figure: ")
                << spoilt << '\n';
    }
}

/// What each row's errors are made of, bias and variance.
void print_bias(std::ostream& out, const json& rows) {
    for (const json& row : rows) {
        const json bias = member(row, "bias");
        if (!bias.is_object()) continue;
        for (const auto& [metric, parts] : bias.items())
            if (member(parts, "text").is_string())
                out << "  " << comparison_row_name(row) << ": " << plain_text(parts["text"]) << '\n';
    }
}

/// Rows that have light which the reference lacks.
void print_marks(std::ostream& out, const json& rows) {
    for (const json& row : rows)
        if (const json mark = member(row, "mark"); mark.is_string())
            out << "  ! " << comparison_row_name(row) << ": " << plain_text(mark) << '\n';
}

}  // namespace

std::string comparison_row_name(const json& row) {
    std::string name = plain_text(member(row, "label"));
    const json parameters = member(row, "parameters");
    if (!parameters.is_object()) return name;
    for (const auto& [key, value] : parameters.items()) name += ", " + printable(key) + " " + plain_text(value);
    return name;
}

void print_comparison_tables(std::ostream& out, const json& comparison) {
    const json table = member(comparison, "table");
    if (!table.is_array() || table.empty()) return;
    const std::vector<std::string> metrics = metrics_of(comparison);
    for (const std::string& metric : metrics) {
        const std::set<double> errors = places(table, kTimeToError, metric);
        print_curve(out, {table, kTimeToError, metric, three_digit_number, human_seconds}, "time to " + metric,
                    {errors.rbegin(), errors.rend()});
        const std::set<double> times = places(table, kErrorAtTime, metric);
        print_curve(out, {table, kErrorAtTime, metric, human_seconds, three_digit_number}, metric + " after",
                    {times.begin(), times.end()});
    }
    print_ends(out, table, metrics);
    print_noise(out, table, metrics);
    print_bias(out, table);
    print_marks(out, table);
}

void print_disturbances(std::ostream& out, const json& comparison) {
    const json warnings = member(comparison, "warnings");
    if (!warnings.is_array() || warnings.empty()) return;
    out << '\n';
    for (const json& warning : warnings) out << "  " << plain_text(warning) << ".\n";
    std::string again;
    if (is_over(comparison))
        for (const json& job : member(comparison, "jobs"))
            if (member(job, "warning").is_string()) again += " " + plain_text(member(job, "id"));
    if (!again.empty()) out << "  Run them again: photonctl jobs repeat" << again << '\n';
}

void print_verdicts(std::ostream& out, const json& comparison) {
    for (const json& headline : member(comparison, "headlines")) {
        const json metric = member(headline, "metric");
        out << "\nBy " << plain_text(metric) << ": " << plain_text(member(headline, "text")) << ".\n";
        for (const json& verdict : member(comparison, "verdicts"))
            if (member(verdict, "metric") == metric) out << "  " << plain_text(member(verdict, "text")) << '\n';
    }
}

}  // namespace photond::cli
