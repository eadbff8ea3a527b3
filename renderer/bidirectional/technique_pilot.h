#pragma once
// The pilot by which techniques are chosen (technique_choice.h).

#include "renderer/bidirectional/bidirectional_scene.h"
#include "renderer/bidirectional/technique_choice.h"

namespace photond {

struct TechniquePilotInputs {
    const RenderContext& context;
    const BidirectionalParams& params;
    double vertices_per_path;  // of light paths
    TechniqueChoices choices;
    float merge_radius_m;  // of the first pass; 0: nothing merges
};

/// The candidate that costs the least for the same error: a pure function of scene, view, parameters and seed.
TechniqueCandidate choose_techniques(const TechniquePilotInputs& inputs, Stats& stats);

}  // namespace photond
