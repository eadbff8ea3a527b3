#include "clients/cli/compare_presets.h"

#include <algorithm>
#include <filesystem>

#include "clients/cli/failure.h"
#include "clients/cli/units.h"

namespace photond::cli {

namespace {

/// [Hoet 2014] (docs/design/sources.md), section 5: Graphs 1 to 4, Table 1. Photon mapping is seen directly, as there;
/// its second entry has as many bounces as light makes, against a reference of one, as the thesis compared. Splats
/// cover the room as in Figure 18 (overlap of some hundreds); large ones have three times the side and a tenth of the
/// photons, as in Table 1. Stratified cells are the thesis': none are joined, one splat each, the photon closest to the
/// cell's mean. Ours: connect, radiometric, no stratification.
ComparePreset photon_splatting_thesis() {
    PresetComparison comparison{};
    comparison.width = 1600, comparison.height = 900;
    comparison.seconds = 30;
    comparison.reference = "path_tracing,indirect_bounces=1";
    comparison.reference_passes = 256;
    comparison.metrics = {"indirect:relative_mse", "indirect:fitted_relative_mse", "indirect:rmse",
                          "indirect:fitted_rmse", "rmse_8bit"};
    comparison.entries = {
        "photon mapping=photon_mapping,gather=direct,boundary=none,indirect_bounces=1",
        "photon mapping (many bounces)=photon_mapping,gather=direct,boundary=none,nearest_photons=200",
        "small splats=photon_splatting,bounces=1,weighting=normalised,splat_size_relative=0.25",
        "large splats=photon_splatting,bounces=1,weighting=normalised,splat_size_relative=0.75",
        ("stratified=photon_splatting,bounces=1,weighting=normalised,splat_size_relative=0.25,stratify=true,"
         "minimum_photons=1,representative=closest_to_mean"),
        "ours=photon_splatting,bounces=1",
    };
    comparison.sweeps = {
        "photon mapping:photons=5000,50000",
        "photon mapping:nearest_photons=50,200",
        "photon mapping (many bounces):photons=5000,50000",
        "small splats:photons=2500,8000,25000",
        "large splats:photons=250,800,2500",
        "stratified:photons=25000,100000",
        "stratified:grid_cells=16,64,256",
        "ours:photons=2500,8000,25000",
    };
    comparison.structures = {"Table 1 of the thesis (highest quality), beside ours",
                             {
                                 {"photon mapping", {"global_map"}, "~50000 photons of 36 bytes: 1.71 MB"},
                                 {"small splats", {"photons"}, "~25000 photons of 36 bytes: 0.85 MB"},
                                 {"large splats", {"photons"}, "~2500 photons of 36 bytes: 0.08 MB"},
                                 {"stratified", {"photons", "stratification"}, "256^3 voxels of 40 bytes: 576 MB"},
                                 {"ours", {"photons"}, "-"},
                             }};
    ComparePreset preset{};
    preset.name = "photon-splatting-thesis";
    preset.text = "Graphs 1-4 and Table 1 of the photon splatting thesis, and what connections make of them";
    for (const std::string_view scene : {"cornell-box-spot", "interior"}) {
        comparison.name = comparison.scene = scene;
        preset.comparisons.push_back(comparison);
    }
    return preset;
}

}  // namespace

std::span<const ComparePreset> compare_presets() {
    static const std::vector<ComparePreset> kPresets{
        photon_splatting_thesis(),    svo_thesis(), progressive(), vcm(), ispm_thesis(),
        visibility_filtering_paper(), real_time(),  moving()};
    return kPresets;
}

const ComparePreset& compare_preset(const std::string& name) {
    std::string all;
    for (const ComparePreset& preset : compare_presets()) {
        if (preset.name == name) return preset;
        all += (all.empty() ? "there is\n  " : "\n  ") + std::string(preset.name) + ": " + std::string(preset.text);
    }
    throw Failure(ExitCode::Usage, name == "help" ? "--preset wants a name" : "no preset is called " + printable(name),
                  all);
}

std::string of_part(const std::string& file, std::string_view part) {
    if (file.empty() || file == "-") return file;
    std::string name(part);
    std::replace(name.begin(), name.end(), '/', '-');
    const std::filesystem::path path(file);
    return path.parent_path() / (path.stem().string() + "-" + name + path.extension().string());
}

}  // namespace photond::cli
