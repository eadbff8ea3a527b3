#pragma once
// What every report carries inside itself (server/comparisons/report_page/).

namespace photond {

extern const char* const kReportCss;
extern const char* const kReportJs;

}  // namespace photond
