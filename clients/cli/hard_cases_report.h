#pragma once
// The table of hard cases for people and for programs.

#include <iosfwd>
#include <nlohmann/json.hpp>
#include <string>

#include "clients/cli/hard_cases_table.h"

namespace photond::cli {

/// Where a table came from.
struct ReportOrigin {
    std::string version;  // of the daemon
    std::string form;     // "short" or "full"
    double seconds = 0;   // it took, from the first job to the last
};

/// {"version", "form", "seconds", "seeds", "effort", "false_alarm", "comparisons", "jobs", "summary", "entries":
/// [{"label", "method"}], "cases": [{"case", "name", "scene", "test", "strains", "text", "cells": [...]}]}; a cell is
/// {"entry", "verdict", "text", "reason", "defects", "notes", "nan_count", "infinity_count", "negative_count",
/// "seconds", "jobs", "shown", "checks"}.
nlohmann::json hard_cases_json(const HardCasesTable& table, const ReportOrigin& origin);

/// One row a cell, then what was found in all.
void print_hard_cases(std::ostream& out, const HardCasesTable& table);

/// "12 of 20 cells hold, 5 break, 3 are not applicable; no NaN, ...", as text and page both end.
std::string summary_text(const HardCasesTable& table);

/// The figures of one cell as the columns of a table: what was checked, bias, its standard error, worst pixel, and the
/// counts of NaN, infinite and negative numbers. "-" where there is none.
struct CellFigures {
    std::string check, bias, standard_error, worst_pixel, faults;
};
CellFigures figures_of(const Cell& cell, const CheckFound* check);

}  // namespace photond::cli
