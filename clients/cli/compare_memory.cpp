#include "clients/cli/compare_memory.h"

#include <algorithm>
#include <optional>
#include <ostream>

#include "clients/cli/text_table.h"
#include "clients/cli/units.h"

namespace photond::cli {

using nlohmann::json;
using namespace nlohmann::literals;

namespace {

constexpr double kSmall = 1024;  // bytes: not worth a name

/// "photons 0.9 MB, splat batch 12 kB": largest first.
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

}  // namespace

std::vector<RowStructures> structures_of(std::span<const RowStatistics> statistics) {
    std::vector<RowStructures> rows;
    for (const RowStatistics& row : statistics) {
        RowStructures& structures = rows.emplace_back(RowStructures{row.label, row.name, {}});
        const auto take = [&structures](const json& members, const std::string& prefix) {
            if (!members.is_object()) return;
            for (const auto& [structure, bytes] : members.items())
                if (bytes.is_number()) structures.bytes[prefix + structure] = bytes.get<double>();
        };
        take(row.statistics.value("/memory/structures"_json_pointer, json()), "");
        take(row.statistics.value("/memory/device_structures"_json_pointer, json()), "device: ");
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

void print_published(std::ostream& out, const std::vector<RowStructures>& rows,
                     const PublishedStructures& published_structures) {
    TextTable table({{std::string(published_structures.text)}, {"published"}, {"ours", Align::Right}, {"of"}});
    for (const PublishedStructure& published : published_structures.structures) {
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
