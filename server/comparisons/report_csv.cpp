#include "server/comparisons/report_csv.h"

#include <algorithm>
#include <set>

namespace photond {
namespace {

using nlohmann::json;

/// A field as RFC 4180 has it: in quotes where it holds a comma, a quote or a line break.
std::string field(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + "\"";
}

std::vector<std::string> columns(std::span<const MeasuredJob> jobs, const std::vector<std::string>& metrics) {
    std::set<std::string> others;
    for (const MeasuredJob& job : jobs)
        for (const CurvePoint& point : job.curve)
            for (const auto& [metric, value] : point.metrics)
                if (std::find(metrics.begin(), metrics.end(), metric) == metrics.end()) others.insert(metric);
    std::vector<std::string> all = metrics;
    all.insert(all.end(), others.begin(), others.end());
    return all;
}

}  // namespace

std::string report_csv(std::span<const MeasuredJob> jobs, const std::vector<std::string>& metrics) {
    const std::vector<std::string> measured = columns(jobs, metrics);
    std::string text = "label,parameters,seed,job,seconds,passes,photons";
    for (const std::string& metric : measured) text += "," + field(metric);
    text += "\r\n";
    for (const MeasuredJob& job : jobs) {
        const std::string begin = field(job.label) + "," + field(job.parameters.dump()) + "," +
                                  std::to_string(job.seed) + "," + field(job.id) + ",";
        for (const CurvePoint& point : job.curve) {
            text += begin + json(point.seconds).dump() + "," + std::to_string(point.passes) + ",";
            if (point.photons) text += std::to_string(*point.photons);
            for (const std::string& metric : measured) {
                const auto found = point.metrics.find(metric);
                text += ",";
                if (found != point.metrics.end() && found->second) text += json(*found->second).dump();
            }
            text += "\r\n";
        }
    }
    return text;
}

}  // namespace photond
