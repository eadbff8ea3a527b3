#pragma once
// How much of a disc of density estimation lies on surface that light can reach, so that sums over its photons can be
// divided by it (photon_mapping's `boundary: "clip"`).
//
// A surface, here, is what photons are counted on: within the disc's thickness, with normals within 60 degrees. A place
// of the disc is covered when, looked for along the disc's normal from above, such a surface is the first to be found,
// and it is seen from above the disc's centre: the floor below a cupboard is there, but no
// photon ever comes to it, and the floor behind a partition is another room's. Photons that are not seen from there do
// not count either, so that light does not leak through what stands between. Of sheets that lie above one another (a
// skirting board and the wall behind it, a carpet and the floor) the uppermost alone counts, so that none is taken away
// twice where they end at one place. The divisor is
//
//   m = integral of K(u) c(u) du over the disc,
//
// with c(u) 0 where the disc is not covered, and else one over the cosine between the surface and the disc: the area of
// surface that the place stands for, so that bent surfaces in even light are right.
//
// What is estimated is 1 / m = 1 + l + l^2 + ..., l = 1 - m the share that is lost: places are looked up in batches
// of kBatch, each spread evenly over the disc, as the kernel is, from a random beginning, so that the share l_i that a
// batch loses has l as its mean, and l_1 l_2 ... l_n has l^n. The series ends with the first batch that loses nothing:
// a disc that is covered everywhere is answered exactly, by one ray for each of kBatch places. Else it is cut off where
// kCovered places were covered, and the rest taken for l_1 ... l_n l' / (1 - l') with l' the mean of all. (One over the
// share of the places that were covered would be too large in the mean.) Discs far from all edges of surfaces take no
// ray (EdgeCells).
//
// A place is looked up by a ray from above the disc's centre to it: it is covered when the ray meets surface in the
// disc's plane there. Where it meets something else, surface is looked for from as high above the place itself, and
// then a ray from above the centre to there says whether it counts.
//
// What it does not know: surfaces that run into others without an edge near (a wall that goes on below the floor).

#include <bit>

#include "renderer/photons/disc_coverage_shared.h"
#include "renderer/photons/edge_cells.h"
#include "renderer/photons/kernel.h"

namespace photond {

class Intersector;
struct Scene;

/// A random number made from two.
inline uint32_t disc_turn(const vec2& u) {
    return hash32(std::bit_cast<uint32_t>(u.x) ^ hash32(std::bit_cast<uint32_t>(u.y)));
}

class DiscCoverage {
public:
    /// For discs of at most `radius_m`. Scene and intersector are borrowed.
    DiscCoverage(const Scene& scene, const Intersector& intersector, float radius_m);

    struct Found {
        float inverse_mass = 1;  // an estimate of 1 / m, at most 1 / kLeastMass
        bool hides = false;  // there is surface in the disc that does not count: photons are to be asked for by sees()
        vec3 eye{0};         // above the centre
    };
    /// Of the disc about p (on a surface; `normal` geometric, unit, the side that is lit). `turn`, a random number,
    /// says which places are looked up. `radius_m` is at most that of the constructor.
    Found look_up(const Kernel& kernel, const vec3& p, const vec3& normal, float radius_m, float thickness_m,
                  uint32_t turn) const;
    /// Whether a photon of such a disc counts.
    bool sees(const Found& found, const vec3& normal, float radius_m, const vec3& photon) const;

    /// A disc's mass is not taken to be less: a needle of surface would turn one photon into a firefly.
    static constexpr float kLeastMass = DISC_LEAST_MASS;
    static constexpr size_t kBatch = DISC_BATCH;      // places that are looked up at once
    static constexpr size_t kCovered = DISC_COVERED;  // places that are waited for
    static constexpr size_t kMostBatches = DISC_MOST_BATCHES;

    const EdgeCells& cells() const { return cells_; }
    uint64_t bytes() const { return cells_.bytes(); }

private:
    const Scene& scene_;
    const Intersector& intersector_;
    EdgeCells cells_;
};

}  // namespace photond
