#include "server/comparisons/report_csv.h"

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

struct Columns {
    std::vector<std::string> values, intervals;  // metrics
};

Columns columns(std::span<const MeasuredJob> jobs, const std::vector<std::string>& metrics) {
    std::set<std::string> others, with_intervals;
    for (const MeasuredJob& job : jobs)
        for (const CurvePoint& point : job.curve) {
            for (const auto& [metric, value] : point.metrics) others.insert(metric);
            for (const auto& [metric, interval] : point.intervals) others.insert(metric), with_intervals.insert(metric);
        }
    for (const std::string& metric : metrics) others.erase(metric);
    Columns found{metrics, {}};
    found.values.insert(found.values.end(), others.begin(), others.end());
    for (const std::string& metric : found.values)
        if (with_intervals.contains(metric)) found.intervals.push_back(metric);
    return found;
}

}  // namespace

std::string report_csv(std::span<const MeasuredJob> jobs, const std::vector<std::string>& metrics) {
    const Columns measured = columns(jobs, metrics);
    std::string text = "label,parameters,seed,job,seconds,passes,photons";
    for (const std::string& metric : measured.values) text += "," + field(metric);
    for (const std::string& metric : measured.intervals)
        text += "," + field(metric + " least") + "," + field(metric + " greatest");
    text += "\r\n";
    for (const MeasuredJob& job : jobs) {
        const std::string begin = field(job.label) + "," + field(job.parameters.dump()) + "," +
                                  std::to_string(job.seed) + "," + field(job.id) + ",";
        for (const CurvePoint& point : job.curve) {
            text += begin + json(point.seconds).dump() + "," + std::to_string(point.passes) + ",";
            if (point.photons) text += std::to_string(*point.photons);
            for (const std::string& metric : measured.values) {
                const auto found = point.metrics.find(metric);
                text += ",";
                if (found != point.metrics.end() && found->second) text += json(*found->second).dump();
            }
            for (const std::string& metric : measured.intervals) {
                const auto found = point.intervals.find(metric);
                text += found == point.intervals.end()
                            ? ",,"
                            : "," + json(found->second.least).dump() + "," + json(found->second.greatest).dump();
            }
            text += "\r\n";
        }
    }
    return text;
}

}  // namespace photond
