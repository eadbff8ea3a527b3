#pragma once
// A comparison as one HTML page that needs nothing beside itself: no network, no other file.

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "server/comparisons/table.h"

namespace photond {

/// An image of the page, PNG.
struct ReportPicture {
    enum class Kind : uint8_t { Beauty, Error, Flip };
    Kind kind = Kind::Beauty;
    std::string name;  // of its row, or "reference"
    std::string job;
    std::vector<uint8_t> png;
};

struct Report {
    nlohmann::json comparison;               // the object that GET /v1/comparisons/{id} gives
    std::vector<nlohmann::json> statistics;  // of each of its jobs, null while it is not over
    ComparisonTable table;
    std::vector<ReportPicture> pictures;  // the reference first, then rows in their order
    std::vector<std::string> notes;       // what is not shown, and why
    double exposure_stops = 0;            // of all beauty images
    std::string version;                  // of the daemon
};

/// The page. Every name of the comparison's is escaped; its style and script are inline, its images data.
std::string report_html(const Report& report);

/// The Content-Security-Policy that permits the page's own style and script, its data images and nothing else.
std::string report_content_security_policy(const std::string& page);

}  // namespace photond
