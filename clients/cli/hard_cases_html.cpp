#include "clients/cli/hard_cases_html.h"

#include "clients/cli/units.h"

namespace photond::cli {

namespace {

// The look of the daemon's comparison reports (server/comparisons/report_page/report.css), as far as tables go.
constexpr const char* kStyle = R"(
:root { color-scheme: light dark; --line: color-mix(in srgb, currentColor 16%, transparent); --soft: color-mix(in srgb, currentColor 64%, transparent); --good: color-mix(in srgb, #009e73 20%, transparent); --bad: color-mix(in srgb, #d55e00 24%, transparent); --worse: color-mix(in srgb, #cc0022 48%, transparent); --warn: #b5560b; }
@media (prefers-color-scheme: dark) { :root { --warn: #f0a050; } }
* { box-sizing: border-box; }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 110rem; margin: 0 auto; padding: 1.2rem 1.4rem 4rem; }
header { border-bottom: 1px solid var(--line); padding-bottom: 0.7rem; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 0.35rem; }
p { margin: 0.4rem 0; max-width: 62rem; }
.soft, small, footer { color: var(--soft); }
.warning { color: var(--warn); }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; min-width: 40%; margin-top: 1.2rem; }
th, td { padding: 0.35rem 0.8rem; border-bottom: 1px solid var(--line); text-align: left; vertical-align: top; }
th:first-child { min-width: 14rem; max-width: 22rem; font-weight: 600; }
td { min-width: 11rem; }
tr.row th { padding-top: 1.4rem; font-size: 1.05rem; border-bottom: none; }
td.holds { background: var(--good); }
td.breaks { background: var(--bad); }
td.defect { background: var(--worse); }
td small, th small, summary small { display: block; font-weight: 400; line-height: 1.3; }
summary { cursor: pointer; }
ul { margin: 0.3rem 0; padding-left: 1.1rem; font-size: 0.88rem; }
footer { margin-top: 3rem; border-top: 1px solid var(--line); padding-top: 0.6rem; font-size: 0.9rem; }
)";

std::string small_text(const std::string& text) { return "<small>" + html_escaped(text) + "</small>"; }

std::string item(const std::string& text) { return "<li>" + html_escaped(text) + "</li>"; }

std::string bounces_text(const HardCheck& check) {
    if (check.layer == "direct" || check.layer == "emitted") return "";
    return check.bounces ? ", " + counted(*check.bounces, "bounce") : ", all bounces";
}

std::string figures_text(const CellFigures& figures) {
    return "bias " + figures.bias + " ± " + figures.standard_error + ", worst pixel " + figures.worst_pixel;
}

/// What is behind the cell's first lines: every check with its figures, the notes, the jobs.
std::string details(const Cell& cell) {
    std::string html = "<ul>";
    for (const CheckFound& found : cell.checks) {
        const CellFigures figures = figures_of(cell, &found);
        const ImageRegion& region = found.check.region;
        std::string text = figures.check + bounces_text(found.check);
        if (!(region == ImageRegion{}))
            text += " in (" + human_number(region.x0) + ", " + human_number(region.y0) + ") to (" +
                    human_number(region.x1) + ", " + human_number(region.y1) + ")";
        html += item(text + ": " + found.text + "; " + figures_text(figures));
    }
    for (const std::string& defect : cell.defects) html += item(defect);
    for (const std::string& note : cell.notes) html += item(note);
    html += item("NaN/infinite/negative: " + figures_of(cell, &cell.checks.front()).faults + "; " +
                 human_seconds(cell.seconds) + " in " + counted(cell.jobs.size(), "job"));
    return html + "</ul>";
}

std::string cell_html(const Cell& cell) {
    if (cell.verdict == Verdict::NotApplicable) return "<td>" + small_text(cell.text) + "</td>";
    const char* kind = !cell.defects.empty() ? "defect" : cell.verdict == Verdict::Holds ? "holds" : "breaks";
    const CellFigures figures = figures_of(cell, cell.shown ? &cell.checks[*cell.shown] : nullptr);
    std::string html = std::string("<td class=\"") + kind + "\"><details><summary>" + html_escaped(cell.text);
    html += small_text(figures.check + ": " + figures_text(figures));
    if (!cell.reason.empty()) html += small_text(cell.reason);
    return html + "</summary>" + details(cell) + "</details></td>";
}

std::string case_html(const HardCasesTable& table, size_t index) {
    const HardCase& hard_case = table.cases[index];
    const std::string columns = std::to_string(table.entries.size());
    std::string html;
    if (index == 0 || table.cases[index - 1].row != hard_case.row)
        html += "<tr class=\"row\"><th colspan=\"" + std::to_string(table.entries.size() + 1) + "\">" +
                html_escaped(hard_case.row) + small_text(hard_case.strains) + "</th></tr>\n";
    html += "<tr><th>" + html_escaped(hard_case.test.empty() ? hard_case.name() : "below the API") +
            small_text(hard_case.text) + "</th>";
    if (!hard_case.test.empty())
        html += "<td colspan=\"" + columns + "\">" + html_escaped("covered by the test " + hard_case.test) + "</td>";
    for (const Cell& cell : table.cells[index]) html += cell_html(cell);
    return html + "</tr>\n";
}

std::string header(const HardCasesTable& table, const ReportOrigin& origin) {
    const RenderLimits& limits = table.options.limits;
    std::string html = "<header><h1>Hard cases</h1>\n<p" +
                       std::string(table.summary().defects > 0 ? " class=\"warning\"" : "") + ">" +
                       html_escaped(summary_text(table)) + ".</p>\n";
    html += "<p class=\"soft\">" +
            html_escaped("photond " + origin.version + ", " + origin.form + " form: " + std::to_string(limits.seeds) +
                         " seeds, " + human_number(table.options.effort) + " times the suggested passes, " +
                         std::to_string(table.jobs) + " jobs in " + human_seconds(origin.seconds) + ".") +
            "</p>\n";
    return html + "</header>\n";
}

std::string footer(const HardCasesTable& table) {
    return "<footer>" +
           html_escaped(
               "Bias: of a region's mean, relative to the known answer, with its standard error between seeds; the "
               "worst of the "
               "three channels. A cell holds when its bias is within Student's t times that error plus the answer's "
               "own "
               "tolerance; the chance that a single cell of the " +
               std::to_string(table.comparisons) + " comparisons breaks without a defect is " +
               three_digit_number(kTableFalseAlarm) +
               " for the whole table (Sidak). Approximations may break by their figure; NaN, infinity, negative "
               "radiance, a "
               "failed or a hanging job may not happen anywhere.") +
           "</footer>\n";
}

}  // namespace

std::string html_escaped(std::string_view text) {
    std::string safe;
    for (const char c : text) switch (c) {
            case '&': safe += "&amp;"; break;
            case '<': safe += "&lt;"; break;
            case '>': safe += "&gt;"; break;
            case '"': safe += "&quot;"; break;
            case '\'': safe += "&#39;"; break;
            default: safe += c;
        }
    return safe;
}

std::string hard_cases_html(const HardCasesTable& table, const ReportOrigin& origin) {
    std::string html =
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Hard cases</title><meta "
        "http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\"><meta "
        "name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<style>" +
        std::string(kStyle) + "</style></head><body>\n" + header(table, origin);
    html += "<div class=\"scroll\"><table><thead><tr><th>case</th>";
    for (const TableEntry& entry : table.entries)
        html += "<th>" + html_escaped(entry.label) +
                small_text(entry.method.value("parameters", nlohmann::json::object()).empty()
                               ? "default parameters"
                               : entry.method["parameters"].dump()) +
                "</th>";
    html += "</tr></thead><tbody>\n";
    for (size_t i = 0; i < table.cases.size(); ++i) html += case_html(table, i);
    return html + "</tbody></table></div>\n" + footer(table) + "</body></html>\n";
}

}  // namespace photond::cli
