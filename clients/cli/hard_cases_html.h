#pragma once
// The table of hard cases as one HTML page that needs nothing beside itself: no network, no script, no other file.

#include <string>

#include "clients/cli/hard_cases_report.h"

namespace photond::cli {

/// Every name and text that came from elsewhere is escaped.
std::string hard_cases_html(const HardCasesTable& table, const ReportOrigin& origin);

/// Text as it may stand in HTML, in attributes too.
std::string html_escaped(std::string_view text);

}  // namespace photond::cli
