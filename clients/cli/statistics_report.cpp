#include "clients/cli/statistics_report.h"

#include <cmath>
#include <ostream>
#include <string>

#include "clients/cli/json_member.h"
#include "clients/cli/text_table.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;

std::string seconds_cell(const json& value) { return value.is_number() ? human_seconds(value.get<double>()) : "-"; }

/// "photons_emitted" as "photons emitted".
std::string words(std::string key) {
    for (char& c : key)
        if (c == '_') c = ' ';
    return printable(key);
}

void print_stages(std::ostream& out, const json& stages) {
    if (!stages.is_array() || stages.empty()) return;
    bool on_gpu = false;
    double total = 0;
    for (const json& stage : stages) {
        on_gpu = on_gpu || member(stage, "gpu_seconds").is_number();
        if (member(stage, "wall_seconds").is_number()) total += stage["wall_seconds"].get<double>();
    }
    std::vector<TextTable::Column> columns{
        {"stage"}, {"wall", Align::Right}, {"", Align::Right}, {"cpu", Align::Right}};
    if (on_gpu) columns.push_back({"gpu", Align::Right});
    TextTable table(columns);
    for (const json& stage : stages) {
        const json wall = member(stage, "wall_seconds");
        const bool share = wall.is_number() && total > 0;
        std::vector<std::string> row{words(plain_text(member(stage, "name"))), seconds_cell(wall),
                                     share ? human_number(std::round(100 * wall.get<double>() / total)) + " %" : "",
                                     seconds_cell(member(stage, "cpu_seconds"))};
        if (on_gpu) row.push_back(seconds_cell(member(stage, "gpu_seconds")));
        table.add_row(std::move(row));
    }
    table.print(out, "  ");
}

/// Numbers of an object, one row each; objects inside (rays by kind) become "rays: camera".
void add_counts(TextTable& table, const json& counts, const std::string& prefix) {
    if (!counts.is_object()) return;
    for (const auto& [key, value] : counts.items()) {
        if (value.is_object())
            add_counts(table, value, prefix + words(key) + ": ");
        else if (value.is_number() && value.get<double>() != 0)
            table.add_row({prefix + words(key), human_count(value.get<double>())});
    }
}

void print_counts(std::ostream& out, const json& statistics) {
    TextTable table({{"count"}, {"", Align::Right}});
    add_counts(table, member(statistics, "counts"), "");
    TextTable rates({{"rate"}, {"", Align::Right}});
    add_counts(rates, member(statistics, "rates"), "");
    if (!table.empty()) table.print(out << '\n', "  ");
    if (!rates.empty()) rates.print(out << '\n', "  ");
}

void print_memory(std::ostream& out, const json& memory) {
    if (!memory.is_object()) return;
    TextTable table({{"memory"}, {"", Align::Right}});
    const json structures = member(memory, "structures");
    if (structures.is_object())
        for (const auto& [name, bytes] : structures.items())
            if (bytes.is_number()) table.add_row({words(name), human_bytes(bytes.get<double>())});
    const json on_device = member(memory, "device_structures");
    if (on_device.is_object())
        for (const auto& [name, bytes] : on_device.items())
            if (bytes.is_number()) table.add_row({"device: " + words(name), human_bytes(bytes.get<double>())});
    for (const char* key : {"accounted_bytes", "baseline_resident_bytes", "peak_resident_bytes", "peak_device_bytes"}) {
        const json bytes = member(memory, key);
        std::string label = words(key);
        if (bytes.is_number() && bytes.get<double>() != 0)
            table.add_row({"= " + label.substr(0, label.rfind(' ')), human_bytes(bytes.get<double>())});
    }
    if (!table.empty()) table.print(out << '\n', "  ");
}

/// What the scene made necessary, as words: names of an array, or of an object those that are true or not zero.
std::string needs_text(const json& needs) {
    std::string text;
    const auto add = [&](const std::string& word) { text += (text.empty() ? "" : ", ") + words(word); };
    if (needs.is_array())
        for (const json& need : needs) add(plain_text(need));
    if (needs.is_object())
        for (const auto& [name, value] : needs.items())
            if ((value.is_boolean() && value.get<bool>()) || (value.is_number() && value.get<double>() != 0)) add(name);
    return text;
}

/// What was left out, and why.
std::string skipped_text(const json& item) {
    if (!item.is_object()) return plain_text(item);
    const json why = member(item, "why");
    return plain_text(member(item, "what")) + (why.is_string() ? " (" + plain_text(why) + ")" : "");
}

/// Empty where the seconds that were asked for were kept.
std::string overshoot_text(const json& clock) {
    const json asked = member(clock, "asked_seconds"), overshoot = member(clock, "overshoot_seconds");
    if (member(clock, "kept") != false) return "";
    return "asked for " + seconds_cell(asked) + ", took " + seconds_cell(overshoot) +
           " more: the first pass is finished, " + "and a pass needs " +
           seconds_cell(member(clock, "seconds_per_pass"));
}

void print_origin(std::ostream& out, const json& statistics) {
    TextTable table({{""}, {""}});
    const auto add = [&](const char* label, const std::string& text) {
        if (!text.empty() && text != "-") table.add_row({label, text});
    };
    add("needs", needs_text(member(statistics, "needs")));
    const json skipped = member(statistics, "skipped");
    if (skipped.is_array())
        for (const json& item : skipped) add("skipped", skipped_text(item));
    for (const json& item : member(statistics, "left_out")) add("left out", plain_text(member(item, "text")));
    const json device = member(statistics, "device");
    add("device", plain_text(device.is_object() ? member(device, "name") : device));
    add("driver", plain_text(member(device, "driver")));
    for (const char* key : {"version", "host_cores", "threads", "seed", "job_hash", "pixel_hash"})
        add(words(key).c_str(),
            key == std::string("seed") ? member(statistics, key).dump() : plain_text(member(statistics, key)));
    for (const char* key : {"nan_count", "infinity_count"}) {
        const json count = member(statistics, key);
        if (count.is_number() && count.get<double>() != 0)
            add(words(key).c_str(), plain_text(count) + " samples dropped");
    }
    add("clock", overshoot_text(member(statistics, "clock")));
    const json cores = member(statistics, "cores"), warning = member(member(statistics, "shared"), "warning");
    if (member(cores, "share").is_number())
        add("cores", three_digit_number(100 * cores["share"].get<double>()) + " % of the processor time it wanted");
    if (warning.is_string())
        add("timing", plain_text(warning));
    else if (member(statistics, "device_shared") == true)
        add("timing", "another job shared the device: not to be compared");
    else if (member(statistics, "host_shared") == true)
        add("timing", "another job ran on another device of this machine");
    if (!table.empty()) table.print(out << '\n', "  ");
}

/// A number, or several with spaces between them (channels, percentiles).
std::string error_cell(const json& value) {
    if (value.is_number()) return three_digit_number(value.get<double>());
    if (!value.is_array() && !value.is_object()) return plain_text(value);
    std::string text;
    for (const json& part : value) text += (text.empty() ? "" : " ") + error_cell(part);
    return text;
}

std::string interval_cell(const json& interval) {
    if (!interval.is_array() || interval.size() != 2) return plain_text(interval);
    return error_cell(interval[0]) + " to " + error_cell(interval[1]);
}

}  // namespace

void print_errors(std::ostream& out, const json& error, const json& reference_error, const json& intervals) {
    if (!error.is_object() || error.empty()) return;
    std::vector<TextTable::Column> columns{{"error"}, {"", Align::Right}};
    const bool noise_known = reference_error.is_object() && !reference_error.empty();
    if (noise_known) columns.push_back({"reference's own noise", Align::Right});
    const bool crossed = intervals.is_object() && !intervals.empty();
    if (crossed) columns.push_back({"90 % interval", Align::Right});
    TextTable table(columns);
    for (const auto& [metric, value] : error.items()) {
        const json interval = member(intervals, metric.c_str());
        if (value.is_null() && interval.is_null()) continue;
        std::vector<std::string> row{printable(metric), error_cell(value)};
        if (noise_known) row.push_back(error_cell(member(reference_error, metric.c_str())));
        if (crossed) row.push_back(interval_cell(interval));
        table.add_row(std::move(row));
    }
    if (!table.empty()) table.print(out, "  ");
}

namespace {

/// Errors, what they are measured against and how far that can be trusted; else what is expected without a reference.
void print_error_part(std::ostream& out, const json& statistics) {
    const json reference = member(statistics, "reference");
    if (member(statistics, "error").is_object()) out << '\n';
    print_errors(out, member(statistics, "error"), member(statistics, "reference_error"),
                 member(statistics, "error_interval"));
    for (const char* key : {"notes", "warnings"})
        for (const json& line : member(reference, key))
            out << "  " << (key == std::string("notes") ? "note: " : "warning: ") << plain_text(line) << '\n';
    const json expected = member(member(statistics, "estimate"), "estimated_relative_mse");
    if (expected.is_number())
        out << "\n  estimated_relative_mse " << three_digit_number(expected.get<double>())
            << ": relative_mse as the passes' own spread lets expect it\n";
}

}  // namespace

void print_statistics(std::ostream& out, const json& statistics) {
    if (!statistics.is_object()) return;
    print_stages(out, member(statistics, "stages"));
    print_counts(out, statistics);
    print_memory(out, member(statistics, "memory"));
    print_origin(out, statistics);
    print_error_part(out, statistics);
    const json warnings = member(statistics, "warnings");
    if (warnings.is_array() && !warnings.empty()) out << '\n';
    for (const json& warning : warnings) out << "  warning: " << plain_text(warning) << '\n';
}

}  // namespace photond::cli
