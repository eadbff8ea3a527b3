#pragma once
// Comparisons that `photonctl compare --preset NAME` knows: an experiment as the options it stands for.

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace photond::cli {

/// A structure whose size was published, beside which ours stands.
struct PublishedStructure {
    std::string_view entry;                    // label of the entry that builds ours
    std::vector<std::string_view> structures;  // of statistics.memory.structures, added up
    std::string_view published;                // what it was made of, and how large
};

struct ComparePreset {
    std::string_view name, text;
    std::vector<std::string_view> scenes;  // one comparison each
    uint32_t width, height;                // pixels
    double seconds;                        // of each job
    std::string_view reference;            // METHOD[,PARAMETER=VALUE...]
    uint32_t reference_passes;
    std::vector<std::string_view> metrics;
    std::vector<std::string_view> entries, sweeps;  // as --entry and --sweep take them
    std::vector<PublishedStructure> structures;
    std::string_view structures_text;  // where those were published
};

std::span<const ComparePreset> compare_presets();
/// Throws Failure(Usage) that lists them.
const ComparePreset& compare_preset(const std::string& name);

/// "report.html" of scene "a/b" as "report-a-b.html"; "-" and an empty name stay.
std::string of_scene(const std::string& file, std::string_view scene);

}  // namespace photond::cli
