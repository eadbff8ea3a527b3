#pragma once
// Stratified photons (thesis 3.2.1 and 4.2): photons of one voxel are splatted as few, so that the number of splats
// follows from the grid and not from the number of photons.
//
// The thesis' grid is dense, 36 bytes and a count for each of its cells (576 MB for 256^3). Here photons are sorted by
// their cell's Morton code, and only cells that hold photons exist. Joining a 2x2x2 block is then joining neighbours in
// that order whose codes agree but for three bits, level by level.

#include <span>
#include <vector>

#include "renderer/core/rng.h"
#include "renderer/methods/photon_splatting/photon_splatting.h"
#include "renderer/photons/reflected_photon.h"

namespace photond {

/// A photon to be splatted, alone or for its cell.
struct SplatSource {
    uint32_t photon;  // index
    /// Power [W] of the splat, channel by channel: of photons with Spread::Rough the factor on their arriving power is
    /// power_w / the photon's own, of which the greatest channel is taken.
    Rgb power_w;
    float photons;  // that it stands for: its area is that of one splat times this
};

struct StratificationSettings {
    Bounds3 bounds;            // of the scene; photons outside, beyond half a cell's width, splat alone
    uint32_t cells = 64;       // along the longest side of the bounds; 1 to 1024
    uint32_t minimum_photons;  // cells that hold fewer are joined in blocks, level by level
    uint32_t splats_per_cell;
    Representative representative;
    bool mean_power = false;  // `normalised`: the cell's mean power instead of the splat's share of its sum
};

/// The cells of one pass: that of p has the integer parts of (p - min) * cells_per_m + first. Half a cell beyond the
/// bounds counts as inside: photons on a wall of the bounds lie beyond it by their rounding.
struct StratificationGrid {
    StratificationGrid(const StratificationSettings& settings, uint64_t seed, uint32_t pass);

    vec3 min, low, high;  // of the bounds, and of what is inside
    vec3 first;           // of the bounds' corner, in cells
    float cells_per_m;
    uint32_t levels;  // of blocks above the cells, up to the one that holds all of them; at most 11
};

/// One pass's splats in the order of their cells' Morton codes, photons outside the grid last: a pure function of
/// (photons, settings, seed, pass), whatever the number of threads. The grid is shifted at random from pass to pass, by
/// less than a cell along each axis. Photons of no power are left out, and count nowhere; powers must be finite and not
/// negative. At most 2^31 - 2 photons.
///
/// Joining (thesis 4.2): the grid is gone through in blocks of 2x2x2. Where a cell of the block holds photons, but
/// fewer than minimum_photons, all that the block holds is one cell from there on. Then blocks take the cells' place,
/// level by level (thesis 3.2.1) up to the whole grid: no cell that results holds fewer than minimum_photons, but for
/// one that holds all there are. Cells without photons call for nothing, as every block that a surface passes through
/// has some.
///
/// Of the cell's photons j with powers Phi_j, m = splats_per_cell are chosen, or all where there are no more than m:
///   random              q_j = 1/n, m equidistant of them from a random one on, splats Phi_J / (m q_J)   unbiased
///   by_power            q_j = share of the mean of RGB: one random offset and m equidistant points on the cumulative
///                       power, splats Phi_J / (m q_J), channel by channel      unbiased: derivations.md
///   closest_to_mean     the photon nearest to the mean position                biased for ever on a fixed grid
///   dominant_direction  the photon whose direction is nearest to the cell's power-weighted mean direction; biased too
/// The last two take one splat with the cell's summed power in each channel (thesis 3.2.1), whatever m. By power, a
/// photon with more than an m-th of the cell's power may be chosen more than once.
///
/// `peak_bytes`: what the sorting took beside the photons and what is returned.
std::vector<SplatSource> stratify(std::span<const ReflectedPhoton> photons, const StratificationSettings& settings,
                                  uint64_t seed, uint32_t pass, uint64_t& peak_bytes);

/// Most bytes that stratify() takes for so many photons, its result included.
uint64_t stratification_bytes(uint64_t photons);

}  // namespace photond
