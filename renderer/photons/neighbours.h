#pragma once
// What a search of a photon map hands back.

#include <cstdint>
#include <vector>

namespace photond {

/// Photons found about a point; scratch that is reused from search to search, by one thread.
struct Neighbours {
    struct Found {
        float distance_sq_m2;
        uint32_t index;  // of the map
    };
    std::vector<Found> found;  // in no particular order
    /// Radius of the disc they are spread over: the fixed radius; of the k nearest the distance of the k-th, which
    /// itself is NOT in `found` (derivations.md, "k nearest photons"); the search radius when fewer than k were there.
    float radius_m = 0;

    // Candidates while a search runs: of no meaning after it.
    std::vector<float> candidate_distances_sq_m2;
    std::vector<uint32_t> candidate_indices;
};

}  // namespace photond
