#include "clients/cli/hard_cases_report.h"

#include <ostream>

#include "clients/cli/text_table.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

json or_null(const std::string& text) { return text.empty() ? json() : json(text); }

json bounces_json(const HardCheck& check) { return check.bounces ? json(*check.bounces) : json(); }

json check_json(const CheckFound& found) {
    const HardCheck& check = found.check;
    json object{{"relation", wire_name(check.relation)},
                {"layer", check.layer},
                {"region", {check.region.x0, check.region.y0, check.region.x1, check.region.y1}},
                {"scene", or_null(check.other_scene)},
                {"scale", check.scale},
                {"bounces", bounces_json(check)},
                {"tolerance", check.tolerance},
                {"holds", found.holds},
                {"text", found.text},
                {"measured", found.measured},
                {"answer", found.answer},
                {"relative", nullptr},
                {"channel", nullptr},
                {"bias", nullptr},
                {"standard_error", nullptr},
                {"half_width", nullptr},
                {"worst_pixel", nullptr}};
    if (found.judgement)
        object.update({{"relative", found.judgement->relative},
                       {"channel", found.judgement->channel},
                       {"bias", found.judgement->bias},
                       {"standard_error", found.judgement->standard_error},
                       {"half_width", found.judgement->half_width}});
    if (found.worst.found)
        object["worst_pixel"] = {{"x", found.worst.x}, {"y", found.worst.y}, {"deviation", found.worst.deviation}};
    return object;
}

json cell_json(const Cell& cell, const TableEntry& entry) {
    json checks = json::array();
    for (const CheckFound& found : cell.checks) checks.push_back(check_json(found));
    return {{"entry", entry.label},
            {"verdict", wire_name(cell.verdict)},
            {"text", cell.text},
            {"reason", or_null(cell.reason)},
            {"defects", cell.defects},
            {"notes", cell.notes},
            {"nan_count", cell.nan},
            {"infinity_count", cell.infinite},
            {"negative_count", cell.negative},
            {"seconds", cell.seconds},
            {"jobs", cell.jobs},
            {"shown", cell.shown ? json(*cell.shown) : json()},
            {"checks", std::move(checks)}};
}

json case_json(const HardCasesTable& table, size_t index) {
    const HardCase& hard_case = table.cases[index];
    json cells = json::array();
    for (size_t j = 0; j < table.cells[index].size(); ++j)
        cells.push_back(cell_json(table.cells[index][j], table.entries[j]));
    return {{"case", hard_case.row},           {"name", hard_case.name()},     {"scene", or_null(hard_case.scene)},
            {"test", or_null(hard_case.test)}, {"strains", hard_case.strains}, {"text", hard_case.text},
            {"cells", std::move(cells)}};
}

std::string with_percent(double relative) { return three_digit_number(100 * relative) + " %"; }

std::string count_text(uint64_t count) { return human_count(static_cast<double>(count)); }

std::string cell_text(const Cell& cell) {
    std::string text = printable(cell.text);
    for (size_t i = 1; i < cell.defects.size(); ++i) text += "; " + printable(cell.defects[i]);
    if (!cell.reason.empty()) text += " (" + cell.reason + ")";
    for (const std::string& note : cell.notes) text += "; " + printable(note);
    return text;
}

}  // namespace

json hard_cases_json(const HardCasesTable& table, const ReportOrigin& origin) {
    const HardCasesTable::Summary summary = table.summary();
    json entries = json::array(), cases = json::array();
    for (const TableEntry& entry : table.entries) entries.push_back({{"label", entry.label}, {"method", entry.method}});
    for (size_t i = 0; i < table.cases.size(); ++i) cases.push_back(case_json(table, i));
    return {{"version", origin.version},
            {"form", origin.form},
            {"seconds", origin.seconds},
            {"seeds", table.options.limits.seeds},
            {"effort", table.options.effort},
            {"false_alarm", kTableFalseAlarm},
            {"comparisons", table.comparisons},
            {"jobs", table.jobs},
            {"summary",
             {{"holds", summary.holds},
              {"breaks", summary.breaks},
              {"not_applicable", summary.not_applicable},
              {"defects", summary.defects}}},
            {"entries", std::move(entries)},
            {"cases", std::move(cases)}};
}

CellFigures figures_of(const Cell& cell, const CheckFound* check) {
    CellFigures figures{"-", "-", "-", "-", "-"};
    if (!check) return figures;
    figures.faults = count_text(cell.nan) + "/" + count_text(cell.infinite) + "/" + count_text(cell.negative);
    figures.check = printable(check->check.layer) + " " + wire_name(check->check.relation);
    for (char& c : figures.check)
        if (c == '_') c = ' ';
    const bool relative = !check->judgement || check->judgement->relative;
    if (check->judgement) {
        const auto text = [&](double value) { return relative ? with_percent(value) : three_digit_number(value); };
        figures.bias = (check->judgement->bias > 0 ? "+" : "") + text(check->judgement->bias);
        figures.standard_error = text(check->judgement->standard_error);
    }
    if (check->worst.found) {
        const bool as_radiance = check->check.relation == Relation::Zero || !relative;
        figures.worst_pixel =
            (check->worst.deviation > 0 ? "+" : "") +
            (as_radiance ? three_digit_number(check->worst.deviation) : with_percent(check->worst.deviation));
    }
    return figures;
}

std::string summary_text(const HardCasesTable& table) {
    const HardCasesTable::Summary summary = table.summary();
    const size_t all = summary.holds + summary.breaks + summary.not_applicable;
    return std::to_string(summary.holds) + " of " + std::to_string(all) + " cells hold, " +
           std::to_string(summary.breaks) + " break, " + std::to_string(summary.not_applicable) +
           " are not applicable; " +
           (summary.defects == 0
                ? std::string("no NaN, infinity, negative radiance, failed or hanging job in any")
                : "NaN, infinity, negative radiance, failed or hanging jobs in " + std::to_string(summary.defects));
}

void print_hard_cases(std::ostream& out, const HardCasesTable& table) {
    TextTable text({{"CASE"},
                    {"METHOD"},
                    {"CHECK"},
                    {"BIAS", Align::Right},
                    {"ST. ERROR", Align::Right},
                    {"WORST PIXEL", Align::Right},
                    {"NAN/INF/NEG", Align::Right},
                    {"VERDICT"}});
    for (size_t i = 0; i < table.cases.size(); ++i) {
        std::string name = printable(table.cases[i].name());
        if (!table.cases[i].test.empty())
            text.add_row({name, "-", "-", "-", "-", "-", "-", "covered by the test " + printable(table.cases[i].test)});
        for (size_t j = 0; j < table.cells[i].size(); ++j) {
            const Cell& cell = table.cells[i][j];
            const CellFigures figures = figures_of(cell, cell.shown ? &cell.checks[*cell.shown] : nullptr);
            text.add_row({name, printable(table.entries[j].label), figures.check, figures.bias, figures.standard_error,
                          figures.worst_pixel, figures.faults, cell_text(cell)});
            name.clear();  // once a case
        }
    }
    text.print(out);
    out << '\n' << summary_text(table) << '\n';
}

}  // namespace photond::cli
