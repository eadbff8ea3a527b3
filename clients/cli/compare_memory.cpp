#include "clients/cli/compare_memory.h"

#include <algorithm>
#include <optional>
#include <ostream>
#include <set>

#include "clients/cli/comparison_view.h"
#include "clients/cli/job_follower.h"
#include "clients/cli/text_table.h"
#include "clients/cli/units.h"

namespace photond::cli {

using nlohmann::json;
using namespace nlohmann::literals;

namespace {

constexpr double kSmall = 1024;  // bytes: not worth a name

/// "photons 0.9 MiB, splat batch 12 KiB": largest first.
std::string text_of(const std::map<std::string, double>& bytes) {
    std::vector<std::pair<double, std::string>> ordered;
    for (const auto& [name, size] : bytes)
        if (size >= kSmall) ordered.emplace_back(size, name);
    std::sort(ordered.begin(), ordered.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    std::string text;
    for (const auto& [size, name] : ordered) text += (text.empty() ? "" : ", ") + name + " " + human_bytes(size);
    return text.empty() ? "-" : text;
}

/// What all rows have alike.
std::map<std::string, double> shared_by_all(const std::vector<RowStructures>& rows) {
    std::map<std::string, double> shared = rows.front().bytes;
    for (const RowStructures& row : rows)
        std::erase_if(shared, [&](const auto& structure) {
            const auto found = row.bytes.find(structure.first);
            return found == row.bytes.end() || found->second != structure.second;
        });
    return shared;
}

/// Null for a job that has none, or has been removed since.
json statistics_of(DaemonClient& daemon, const std::string& job_id) {
    try {
        return daemon.get(resource_path("jobs", job_id)).value("statistics", json());
    } catch (const Failure& failure) {
        constexpr int kNotFound = 404;
        if (failure.problem.is_object() && failure.problem.value("status", 0) == kNotFound) return nullptr;
        throw;
    }
}

}  // namespace

std::vector<RowStructures> structures_of(DaemonClient& daemon, const json& comparison) {
    std::vector<RowStructures> rows;
    std::set<std::string> seen;
    for (const json& job : comparison.value("jobs", json::array())) {
        const std::string name = comparison_row_name(job);
        if (!is_over(job) || seen.contains(name)) continue;
        const json statistics = statistics_of(daemon, job.at("id").get<std::string>());
        if (!statistics.is_object()) continue;
        seen.insert(name);
        RowStructures row{plain_text(job.value("label", json())), name, {}};
        const json structures = statistics.value("/memory/structures"_json_pointer, json::object());
        for (const auto& [structure, bytes] : structures.items())
            if (bytes.is_number()) row.bytes[structure] = bytes.get<double>();
        const json on_device = statistics.value("/memory/device_structures"_json_pointer, json());
        if (on_device.is_object())
            for (const auto& [structure, bytes] : on_device.items())
                if (bytes.is_number()) row.bytes["device: " + structure] = bytes.get<double>();
        rows.push_back(std::move(row));
    }
    return rows;
}

void print_structures(std::ostream& out, const std::vector<RowStructures>& rows) {
    if (rows.empty()) return;
    const std::map<std::string, double> shared =
        rows.size() > 1 ? shared_by_all(rows) : std::map<std::string, double>();
    TextTable table({{"memory by structure"}, {""}});
    for (const RowStructures& row : rows) {
        std::map<std::string, double> own = row.bytes;
        std::erase_if(own, [&](const auto& structure) { return shared.contains(structure.first); });
        table.add_row({row.name, text_of(own)});
    }
    if (!shared.empty()) table.add_row({"each", text_of(shared)});
    table.print(out << '\n', "  ");
}

void print_published(std::ostream& out, const std::vector<RowStructures>& rows, const ComparePreset& preset) {
    TextTable table({{std::string(preset.structures_text)}, {"published"}, {"ours", Align::Right}, {"of"}});
    for (const PublishedStructure& published : preset.structures) {
        std::optional<double> most;
        std::string row_name;
        for (const RowStructures& row : rows) {
            if (row.label != published.entry) continue;
            double bytes = 0;
            for (const std::string_view structure : published.structures)
                if (const auto found = row.bytes.find(std::string(structure)); found != row.bytes.end())
                    bytes += found->second;
            if (most && bytes <= *most) continue;
            most = bytes, row_name = row.name;
        }
        std::string structures;
        for (const std::string_view structure : published.structures)
            structures += (structures.empty() ? "" : " + ") + std::string(structure);
        table.add_row({most ? row_name : std::string(published.entry), std::string(published.published),
                       most ? human_bytes(*most) : "-", structures});
    }
    if (!table.empty()) table.print(out << '\n', "  ");
}

}  // namespace photond::cli
