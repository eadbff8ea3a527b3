#pragma once
// A radius for density estimates by what a pilot's photons say of density.

#include "renderer/photons/photon_map.h"

namespace photond {

struct PilotRadius {
    double photons_in_radius;  // of a pass, that the radius is to hold
    double bright_share;       // of the power is where they are more
    double paths_over_pilot;   // light paths of a pass over the pilot's
};

/// The radius at which a pass's photons are as many as are wanted: of each place that of its density, and of the places
/// the one that `bright_share` of the power is within. `pilot` is searched for its k nearest; where it has fewer than k
/// photons: its search radius. [m]
float radius_of_pilot(const PhotonMap& pilot, const PilotRadius& wanted);

}  // namespace photond
