#include "server/comparisons/left_out_marks.h"

#include "protocol/enumerated.h"

namespace photond {
namespace {

/// Of indirect light there is nothing in it.
bool is_of_direct_light(const std::string& metric) {
    return metric.starts_with("direct:") || metric.starts_with("emitted:");
}

std::string row_names(const ComparisonTable& table, const std::vector<size_t>& rows) {
    std::vector<std::string> names;
    names.reserve(rows.size());
    for (const size_t row : rows) names.push_back(row_name(table.rows[row].label, table.rows[row].parameters));
    return enumerated(names);
}

}  // namespace

PathsLeftOut lacked_by_reference(const ComparisonTable& table, const TableRow& row) {
    if (!table.reference_left_out || !row.left_out) return {};
    return table.reference_left_out->without(*row.left_out);
}

std::string mark_text(const ComparisonTable& table, const TableRow& row) {
    const PathsLeftOut lacked = lacked_by_reference(table, row);
    if (lacked.empty()) return "";
    const PathsLeftOut own = row.left_out->without(*table.reference_left_out);
    return "the reference lacks " + lacked.text() + ": what this entry has of it counts as error" +
           (own.empty() ? "" : "; so does what it lacks itself, " + own.text());
}

std::vector<size_t> marked_rows(const ComparisonTable& table, const std::string& metric) {
    std::vector<size_t> marked;
    if (is_of_direct_light(metric)) return marked;
    for (size_t row = 0; row < table.rows.size(); ++row)
        if (!lacked_by_reference(table, table.rows[row]).empty()) marked.push_back(row);
    return marked;
}

std::string marked_text(const ComparisonTable& table, const std::string& metric) {
    const std::vector<size_t> marked = marked_rows(table, metric);
    if (marked.empty()) return "";
    const bool one = marked.size() == 1;
    return "; " + row_names(table, marked) + (one ? " has" : " have") +
           " light that the reference lacks, which counts as " + (one ? "its" : "their") + " error";
}

std::string lacking_reference_text(const ComparisonTable& table, const std::string& metric) {
    const std::vector<size_t> marked = marked_rows(table, metric);
    if (marked.empty()) return "";
    return ", by a reference that lacks light which " + row_names(table, marked) +
           (marked.size() == 1 ? " has" : " have");
}

}  // namespace photond
