#pragma once
// Which light paths a pass's virtual point lights are of, where these are placed by what they bring to the picture: a
// path's worth is what its lights bring to some of the points that the eye sees, shadows among it
// (CameraImportance::brought()). GPU twin: path_selection_gpu.h.
//
// A path's target is its worth over the mean worth, Phi_v, plus a share that all have. Phi_v is frozen: a pilot finds
// it by numbers of its own before the first pass. So what is chosen depends on nothing but the pass, and the mean over
// passes is the light's transport:
// * Acceptance: each of a fixed number of candidates is kept with a probability of min(target, 1) and has its power
//   over that. The pilot says how many candidates leave about as many paths as there are to be; where more are kept
//   than that, all are dropped with one more chance.
// * Metropolis: short chains go through the paths' numbers in proportion to the target. Each pass has new chains, which
//   start at candidates drawn in proportion to the target, and count for the candidates' mean target over each state's
//   own: that is what makes the mean right, however short a chain is [Veach 1997, 11.3.1]. Chains draw independent
//   numbers, as a step may know nothing of those before.
// Lights of paths that bring little have more power each, and choices among the lights (vpl_choice.h), which go by it
// and not by V, would pick them as often as before, mostly for nothing. So lights carry the share of their paths' light
// that is seen where it would arrive: choices take them for that share of their size.
//
// [Georgiev and Slusallek 2010] Simple and Robust Iterative Importance Sampling of Virtual Point Lights. Eurographics
// (short papers). Departure: candidates are as many in each pass, which leaves no bias where the number kept is random.
// [Segovia, Iehl, Péroche 2007] Metropolis Instant Radiosity. CGF 26(3). Departure: many short chains in place of one,
// whose starts are resampled; lights keep what their states stand for, in place of one equal power.
// [Veach 1997] Robust Monte Carlo Methods for Light Transport Simulation. Thesis, Stanford.
// [Kelemen, Szirmay-Kalos, Antal, Csonka 2002] A Simple and Robust Mutation Strategy for the Metropolis Light Transport
// Algorithm. CGF 21(3): large and small steps of the numbers.

#include "renderer/many_lights/camera_importance.h"
#include "renderer/many_lights/path_selection_shared.h"
#include "renderer/many_lights/vpl_tracer.h"

namespace photond {

/// Where a pass's lights are placed.
enum class VplPlacement : uint8_t {
    Flux,    // where flux is
    Camera,  // where the flux is whose texels' light arrives at what the camera sees (camera_importance.h)
    Acceptance,
    Metropolis,
};
inline bool selects_paths(VplPlacement placement) {
    return placement == VplPlacement::Acceptance || placement == VplPlacement::Metropolis;
}

/// What is frozen before the first pass.
struct PathPilot {
    float mean_worth = 0;     // Phi_v; 0: nothing reaches what the eye sees, and all paths are alike
    uint32_t candidates = 1;  // of a pass that are rated before any is chosen

    /// From the worth of independent paths of which a pass is to have `vpls`.
    PathPilot(VplPlacement placement, std::span<const float> worth, uint32_t vpls);
    float target(float worth) const;
};

/// Before the first pass, from the reference's domain: its numbers are no pass's.
PathPilot find_path_pilot(VplPlacement placement, const VplTracer& tracer, const CameraImportance& seen,
                          const Intersector& intersector, uint32_t vpls, uint64_t seed, Stats& stats);

/// Shape of a pass's chains.
struct ChainShape {
    explicit ChainShape(uint32_t vpls)
        : chains((vpls + CHAIN_STATES - 1) / CHAIN_STATES), states(vpls / ((vpls + CHAIN_STATES - 1) / CHAIN_STATES)) {}
    uint32_t chains, states;  // states of each, the start among them
};

/// VplTracer::trace() by the paths that are chosen for what the pass sees: `vpls` at most.
TracedReflections trace_by_worth(VplPlacement placement, const PathPilot& pilot, const VplTracer& tracer,
                                 const CameraImportance& seen, const Intersector& intersector, uint32_t vpls,
                                 uint64_t seed, uint32_t pass, Stats& stats, const CancelToken& cancel);

}  // namespace photond
