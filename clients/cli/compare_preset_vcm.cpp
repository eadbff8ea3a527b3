// Vertex connection and merging beside what it is made of, for the same time: the box of SmallVCM ([Georgiev et al.
// 2012]; docs/design/sources.md), a door that stands ajar, a furnished room, and light that comes by glass and is seen
// through glass.
//
// Path tracing and its bidirectional kind know no light that delta scatterings alone carry from points and suns to
// where mirrors and glass show it. The references of such scenes merge, with other random numbers, more light paths and
// a smaller radius; those of the others are unbiased.

#include "clients/cli/compare_presets.h"

namespace photond::cli {

namespace {

enum class Reference { Unbiased, Merging };

PresetComparison on_scene(std::string_view scene, Reference reference) {
    PresetComparison comparison{};
    comparison.name = comparison.scene = scene;
    comparison.width = comparison.height = 256;
    comparison.seconds = 60;
    comparison.reference = reference == Reference::Unbiased
                               ? "bidirectional_path_tracing,adapt=false"
                               : "vertex_connection_and_merging,adapt=false,light_paths=2,nearest_vertices=6";
    comparison.reference_passes = 512;
    comparison.metrics = {"relative_mse", "indirect:relative_mse"};
    comparison.entries = {
        "path tracing=path_tracing",
        "bidirectional=bidirectional_path_tracing",
        "stochastic progressive=stochastic_progressive_photon_mapping",
        "vertex connection and merging=vertex_connection_and_merging",
        "all techniques=vertex_connection_and_merging,adapt=false",
        "recursive weights=vertex_connection_and_merging,weights=recursive",
        "own paths=bidirectional_path_tracing,adapt=false,connections=own_path",
    };
    return comparison;
}

}  // namespace

ComparePreset vcm() {
    ComparePreset preset{};
    preset.name = "vcm";
    preset.text =
        "path tracing, bidirectional path tracing, progressive photon mapping and what joins them, in equal time";
    for (const std::string_view scene : {"small-vcm/ceiling", "small-vcm/sky", "doors/ajar", "interior"})
        preset.comparisons.push_back(on_scene(scene, Reference::Unbiased));
    for (const std::string_view scene : {"small-vcm/sun", "small-vcm/point", "progressive/lamp", "progressive/box",
                                         "progressive/torus", "progressive/mirror-bathroom", "progressive/flashlight"})
        preset.comparisons.push_back(on_scene(scene, Reference::Merging));
    return preset;
}

}  // namespace photond::cli
