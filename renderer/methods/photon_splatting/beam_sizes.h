#pragma once
// How wide beams are: what mirrors and glass cast is spread over a disc about where each of its photons lands, so the
// disc should hold few photons where they lie close, and never be wider than what casts them. By the size of the scene
// alone a glass on a large floor would glow a metre about itself.
//
// Photons of a pilot, of their own random numbers, say how close photons lie: the places where its beams land are cut
// into cells of few, a cell as wide as it needs to be, and each cell knows the distance of its photons to their k-th
// nearest. It is a pure function of (scene, parameters, seed), as SplatSizes is.

#include <span>
#include <string>
#include <vector>

#include "renderer/methods/photon_splatting/splat_settings.h"
#include "renderer/methods/photon_splatting/splat_shared.h"
#include "renderer/photons/photon_tracer.h"

namespace photond {

/// Half of the width of each instance that sends beams [m], infinite for all others: of the second longest side of its
/// box, so that plates count by their breadth and rods by their thickness. `threshold`: GGX alpha below which lobes do.
std::vector<float> caster_radii_m(const Scene& scene, float threshold);

/// What a result says where beams of one width are wider than something that casts them; empty where they are not.
std::string wide_beams_text(float beam_radius_m, std::span<const float> caster_radii_m);

/// Where a beam's photon lands.
struct BeamLanding {
    vec3 position{0};
    float distance_m = 0;  // from where the beam left
    uint32_t caster = 0;   // ReflectedPhoton::caster()
};

/// Beams are no wider than where a pilot's land close together, than their caster, nor than the way they came: nearer
/// to the surface they leave a bundle would begin within it, and the floor under a glass darkens.
class BeamSizes {
public:
    /// The same radius everywhere.
    explicit BeamSizes(float most_m) : most_m_(most_m) {}

    /// By where a pilot's beams land, for passes of `paths` light paths; no beam is wider than most_m. The radii are
    /// caster_radii_m()'s. Adds to counts.photon_rays.
    BeamSizes(float most_m, uint32_t paths, std::vector<float> caster_radii_m, const TracedReflections& pilot,
              const Intersector& intersector, Counts& counts);

    /// Radius [m] in the first pass of a beam that stands for so many photons.
    float radius_m(const BeamLanding& landing, float photons) const;

    /// For the twin in splat_make.comp. Borrows.
    std::span<const gpu::BeamCell> cells() const { return cells_; }
    std::span<const float> casters() const { return casters_m_; }
    uint32_t levels() const { return levels_; }

    uint64_t bytes() const { return cells_.capacity() * sizeof(gpu::BeamCell) + casters_m_.capacity() * sizeof(float); }

private:
    class Builder;

    float most_m_;
    uint32_t levels_ = 0;  // of splits
    /// A complete binary tree as a heap, node 1 the root and node n above 2n and 2n + 1; empty: most_m everywhere.
    std::vector<gpu::BeamCell> cells_;
    std::vector<float> casters_m_;  // by instance
};

}  // namespace photond
