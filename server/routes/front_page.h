#pragma once
// The first page to look at: its files, carried inside the program (server/routes/front_page/).

namespace photond::http {

extern const char* const kFrontPageHtml;
extern const char* const kFrontPageCss;
extern const char* const kFrontPageJs;

}  // namespace photond::http
