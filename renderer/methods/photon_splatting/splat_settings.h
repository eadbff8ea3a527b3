#pragma once
// The parameters of splatting as lengths and choices in one scene.

#include "renderer/methods/photon_splatting/photon_splatting.h"

namespace photond {

struct SplatSettings {
    SplatSettings(const PhotonSplattingParams& params, const Scene& scene);

    bool connects;    // Lambert and rough photons by connection, else all as beams
    bool normalised;  // weights are kept, and divided out
    bool visibility;
    Kernel filter;
    float radius_m;       // half of splat_size: of a photon that splats alone
    float beam_radius_m;  // the most of beams, in the first pass; beside connections, which do not blur, a quarter
    // Beams begin so far before the hit of their photon's ray, and light so far from there: metres, and radii that they
    // have in the first pass.
    float step_back_m, step_back_radii;
    float depth_m, depth_radii;
    float shrink_alpha;  // 1: no shrinking
    uint32_t shadow_resolution;
    float surface_area_m2;  // of the scene; `normalised` makes powers colours with it

    /// Radius of the beams of that pass over that of the first one: sqrt(Gamma(i + alpha) / (Gamma(1 + alpha)
    /// Gamma(i + 1))), i = pass + 1 (derivations.md, "Radius of pass i").
    float shrink(uint32_t pass) const;
};

}  // namespace photond
