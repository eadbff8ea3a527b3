#pragma once
// The dashboard (clients/dashboard): its files, carried inside the program, and the pages it answers for.

#include <span>
#include <string_view>

namespace photond::http {

struct DashboardFile {
    std::string_view path;  // "/assets/index-Cl-Kz-gW.js"
    std::string_view media_type;
    std::string_view etag;  // SHA-256 of the contents
    std::string_view bytes;
    std::string_view gzip;
};

/// All there are; written by the build.
std::span<const DashboardFile> dashboard_files();

/// Patterns of the paths at which the dashboard is shown; which of its rooms that is, it finds out by itself
/// (clients/dashboard/src/app/app.tsx).
inline constexpr const char* kDashboardPages[] = {
    "/",          "/jobs",           "/jobs/{id}", "/render",         "/compare", "/studies", "/studies/{id}",
    "/sequences", "/sequences/{id}", "/scenes",    "/scenes/{scene}", "/api",
};

}  // namespace photond::http
