#pragma once
// Experiments that `photonctl compare --preset NAME` knows: comparisons as the options they stand for.

#include <cstdint>
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

struct PublishedStructures {
    std::string_view text;  // where those were published
    std::vector<PublishedStructure> structures;
};

/// A stage whose time was published, beside which ours stands, or one of ours that was not.
struct PublishedStage {
    std::string_view name;                 // as published
    std::vector<std::string_view> stages;  // of statistics.stages, added up
    bool once;                             // ours is done when a job begins, not in every pass
    std::vector<double> published_ms;      // of each of PublishedStages::rows; empty: not published
};

struct PublishedStages {
    std::string_view text;               // where those were published
    std::vector<std::string_view> rows;  // of the comparison, with what their sweep gave: "thesis, vpls 512"
    std::vector<PublishedStage> stages;
};

/// Frames of a moving scene, which are measured by error, flicker and lag (compare_sequences.h).
struct PresetFrames {
    uint32_t count = 0;  // 0: the comparison is of images
    double fps = 0;
    uint32_t animation = 0;  // of the scene's, by index
};

/// One comparison of a preset.
struct PresetComparison {
    std::string_view name;    // --part, and in the names of its reports
    std::string_view scene;   // built in; where there is a `file`, what stands in for it; empty: nothing does
    std::string_view file;    // a scene that does not come with the program, looked for in --scene-folder
    std::string_view camera;  // of the file; empty: its first
    uint32_t width, height;   // pixels
    double seconds;           // on each job's clock; where `frames` is 0
    /// Not 0: the passes of each job and of the reference, which then is a job like the others, with their random
    /// numbers: all have the same rays from the eye, and differ by what their methods differ in. --seconds and
    /// --reference-passes do not change such frames, --passes does.
    uint32_t frames;
    std::string reference;      // METHOD[,PARAMETER=VALUE...]
    uint32_t reference_passes;  // where `frames` is 0
    std::vector<std::string> metrics;
    std::vector<std::string> entries, sweeps;  // as --entry and --sweep take them
    PublishedStructures structures;
    PublishedStages stages;
    PresetFrames sequence;
};

struct ComparePreset {
    std::string_view name, text;
    std::vector<PresetComparison> comparisons;
};

std::span<const ComparePreset> compare_presets();
/// Throws Failure(Usage) that lists them.
const ComparePreset& compare_preset(const std::string& name);

/// compare_preset_svo.cpp
ComparePreset svo_thesis();
/// compare_preset_progressive.cpp
ComparePreset progressive();
/// compare_preset_vcm.cpp
ComparePreset vcm();
/// compare_preset_ispm.cpp
ComparePreset ispm_thesis();
/// compare_preset_visibility.cpp
ComparePreset visibility_filtering_paper();
/// compare_preset_real_time.cpp
ComparePreset real_time();
/// compare_preset_moving.cpp
ComparePreset moving();

/// "report.html" of comparison "a/b" as "report-a-b.html"; "-" and an empty name stay.
std::string of_part(const std::string& file, std::string_view part);

}  // namespace photond::cli
