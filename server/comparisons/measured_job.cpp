#include "server/comparisons/measured_job.h"

namespace photond {
namespace {

using nlohmann::json;

std::optional<uint64_t> count_of(const json& object, const char* key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_number_unsigned() ? std::optional(found->get<uint64_t>()) : std::nullopt;
}

/// The numbers of an object of metrics; those with several values are no figures of a table.
std::map<std::string, double> figures(const json& metrics) {
    std::map<std::string, double> found;
    if (!metrics.is_object()) return found;
    for (const auto& [metric, value] : metrics.items())
        if (value.is_number()) found[metric] = value.get<double>();
    return found;
}

/// {metric: [least, greatest]}
std::map<std::string, Interval> intervals(const json& metrics) {
    std::map<std::string, Interval> found;
    if (!metrics.is_object()) return found;
    for (const auto& [metric, ends] : metrics.items())
        if (ends.is_array() && ends.size() == 2 && ends[0].is_number() && ends[1].is_number())
            found[metric] = {ends[0].get<double>(), ends[1].get<double>()};
    return found;
}

CurvePoint curve_point(const json& source) {
    CurvePoint point;
    point.seconds = source.value("seconds", 0.0);
    point.passes = source.value("passes", uint32_t{0});
    point.photons = count_of(source, "photons");
    for (const auto& [metric, value] : figures(source.value("metrics", json()))) point.metrics[metric] = value;
    point.intervals = intervals(source.value("intervals", json()));  // results of before have none
    return point;
}

/// What rendering took beside the idle process, host and device together. A software device's memory is the host's:
/// it is among what was resident.
std::optional<uint64_t> peak_bytes(const json& statistics) {
    const json memory = statistics.value("memory", json::object()), device = statistics.value("device", json::object());
    const auto peak = count_of(memory, "peak_resident_bytes");
    if (!peak) return std::nullopt;
    const uint64_t baseline = count_of(memory, "baseline_resident_bytes").value_or(0);
    const bool on_card = device.value("software", json()) == false;
    return (*peak > baseline ? *peak - baseline : 0) +
           (on_card ? count_of(memory, "peak_device_bytes").value_or(0) : 0);
}

}  // namespace

void add_measurements(MeasuredJob& job, const json& curve, const json& statistics) {
    if (curve.is_array())
        for (const json& point : curve) job.curve.push_back(curve_point(point));
    if (!statistics.is_object()) return;
    job.error = figures(statistics.value("error", json()));
    job.error_interval = intervals(statistics.value("error_interval", json()));
    job.reference_error = figures(statistics.value("reference_error", json()));
    job.peak_bytes = peak_bytes(statistics);
    job.loss = CoreLoss::of_statistics(statistics);
    const json counts = statistics.value("counts", json::object());
    job.photons = count_of(counts, "photons_emitted");
    if (job.photons == 0) job.photons.reset();  // a method without photons
}

}  // namespace photond
