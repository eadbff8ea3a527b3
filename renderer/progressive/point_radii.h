#pragma once
// Radii of each pixel's own, by the photons that it has counted: the rules `local` and `tested`. Passes build on those
// before.
//
//   local   r^2 <- r^2 (N + alpha M) / (N + M), N <- N + alpha M, M the photons of the pass; nothing where M = 0.
//           [Hachisuka et al. 2008, Eq. 10]
//   tested  Photons are gathered since the radius last changed. At each doubling of their number they are tested for
//           what even light does not do; where that is found r^2 is halved, and all begins anew. The test is asked for
//           ever, so that the radius goes to zero. [Lin et al. 2020] count photons by sector of the disc (chi-squared).
//           The radial test asks whether they lie nearer to the centre or to the rim than in light that varies
//           linearly: such light does a radial kernel no harm.

#include "renderer/progressive/disc_radii.h"

namespace photond {

std::unique_ptr<DiscRadii> make_point_radii(const DiscRadiiInputs& inputs, Stats& stats);
/// The pilots included, which are kept: a pixel may ask for its first radius in any pass.
DiscRadiiBytes point_radii_bytes(const ProgressiveParams& params, uint32_t hit_point_sets, const Workload& workload);

}  // namespace photond
