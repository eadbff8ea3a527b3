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
    float merge_radius_m;          // of the first pass; 0: nothing merges
    float caustic_radius;          // of TechniqueNumbers
    const RadiusMap* radii;        // each place's own, of which that is the greatest; nullptr: there is one for all
    const DiscCoverage* coverage;  // where there is merging
};

/// What a candidate would be everywhere.
struct JudgedCandidate {
    TechniqueCandidate candidate;
    double relative_variance;  // of a pixel and pass, mean over the image
    double cost;               // counted_cost()
};
struct TechniquePilot {
    std::vector<JudgedCandidate> candidates;
    uint32_t block_side;      // of the image's blocks [pixels]: whole tiles of the eye's
    ChosenTechniques chosen;  // among the candidates
};
/// A pure function of scene, view, parameters and seed.
TechniquePilot run_technique_pilot(const TechniquePilotInputs& inputs, Stats& stats);

}  // namespace photond
