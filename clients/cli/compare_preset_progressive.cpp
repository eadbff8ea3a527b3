// Progressive photon mapping on the scenes that its publications show ([Hachisuka et al. 2008], Figures 6 to 10;
// [Hachisuka and Jensen 2009], Figure 1; docs/design/sources.md), or on others like them: a lamp, a box, a torus in a
// glass cube, a bathroom, a flashlight. Curves have a point after 1, 2, 4 ... passes, those of Figure 5 among them.
//
// No path tracer makes a reference of light that comes by glass and is seen through glass. The reference is of the same
// family, with other random numbers and more than what it judges; its own radii shrink, too.

#include "clients/cli/compare_presets.h"

namespace photond::cli {

namespace {

const std::string kReference = "probabilistic_progressive_photon_mapping,photons=400000,nearest_photons=20";

PresetComparison on_scene(std::string_view scene) {
    PresetComparison comparison{};
    comparison.name = comparison.scene = scene;
    comparison.width = 320, comparison.height = 240;
    comparison.seconds = 60;
    comparison.reference = kReference;
    comparison.reference_passes = 512;
    comparison.metrics = {"relative_mse", "indirect:relative_mse"};
    return comparison;
}

/// The methods beside each other.
PresetComparison methods_on(std::string_view scene) {
    PresetComparison comparison = on_scene(scene);
    comparison.entries = {
        "path tracing=path_tracing",
        "photon mapping=photon_mapping",
        "photon map seen directly=photon_mapping,gather=direct",
        "reverse=reverse_photon_mapping",
        "progressive=progressive_photon_mapping",
        "stochastic=stochastic_progressive_photon_mapping",
        "probabilistic=probabilistic_progressive_photon_mapping",
    };
    return comparison;
}

/// What radii do: by rule, by alpha, and by the kernel.
PresetComparison radii_on(std::string_view scene, std::string_view name) {
    PresetComparison comparison = on_scene(scene);
    comparison.name = name;
    comparison.entries = {
        "rule=stochastic_progressive_photon_mapping",
        "tested by sectors=stochastic_progressive_photon_mapping,radius_rule=tested,test=sector",
        "global=probabilistic_progressive_photon_mapping,radius_rule=global",
        "kernel=probabilistic_progressive_photon_mapping,radius_rule=global",
    };
    comparison.sweeps = {
        "rule:radius_rule=global,trained,local,tested",
        "global:alpha=0.3,0.5,0.667,0.8,0.9",
        "kernel:kernel=constant,gaussian,epanechnikov",
    };
    return comparison;
}

}  // namespace

ComparePreset progressive() {
    ComparePreset preset{};
    preset.name = "progressive";
    preset.text =
        "progressive photon mapping's methods, radius rules, alphas and kernels where light comes through glass";
    for (const std::string_view scene :
         {"progressive/lamp", "progressive/box", "progressive/torus", "progressive/torus-spot",
          "progressive/mirror-bathroom", "progressive/flashlight"})
        preset.comparisons.push_back(methods_on(scene));
    preset.comparisons.push_back(radii_on("progressive/torus", "progressive/torus-radii"));
    preset.comparisons.push_back(radii_on("cornell-box-glass", "cornell-box-glass-radii"));
    return preset;
}

}  // namespace photond::cli
