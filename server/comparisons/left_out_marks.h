#pragma once
// Rows that have light which their reference lacks: they are marked, for that light counts as their error.

#include <string>
#include <vector>

#include "server/comparisons/table.h"

namespace photond {

/// What the reference leaves out and the row does not; none where that is not known of both.
PathsLeftOut lacked_by_reference(const ComparisonTable& table, const TableRow& row);

/// "the reference lacks light ...: what this entry has of it counts as error", and what the entry lacks itself that the
/// reference has; empty for a row that is not marked.
std::string mark_text(const ComparisonTable& table, const TableRow& row);

/// Rows that are marked, where the metric is of a layer in which bounced light is.
std::vector<size_t> marked_rows(const ComparisonTable& table, const std::string& metric);
/// "; a and b have light that the reference lacks, which counts as their error"; empty where none is marked.
std::string marked_text(const ComparisonTable& table, const std::string& metric);
/// ", by a reference that lacks light which a and b have"; likewise.
std::string lacking_reference_text(const ComparisonTable& table, const std::string& metric);

}  // namespace photond
