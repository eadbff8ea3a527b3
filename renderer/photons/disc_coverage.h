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
// What is estimated is 1 / m = 1 + l + l^2 + ..., l = 1 - m the share that is lost: places are looked up in batches,
// each spread evenly over the disc, as the kernel is, from a random beginning, so that the share l_i that a batch loses
// has l as its mean, and l_1 l_2 ... l_n has l^n. The series ends with the first batch that loses nothing: a disc that
// is covered everywhere is answered exactly, by one ray for each place of one batch. Else it is cut off where as many
// places as a batch has were covered, and the rest taken for l_1 ... l_n l' / (1 - l') with l' the mean of all. (One
// over the share of the places that were covered would be too large in the mean.) Discs far from all edges of surfaces
// take no ray (EdgeTree).
//
// A place is looked up by a ray from above the disc's centre to it: it is covered when the ray meets surface in the
// disc's plane there. Where it meets something else, surface is looked for from as high above the place itself, and
// then a ray from above the centre to there says whether it counts.
//
// What it does not know: surfaces that run into others without an edge near (a wall that goes on below the floor).

#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <span>

#include "renderer/core/rng.h"
#include "renderer/photons/disc_coverage_shared.h"
#include "renderer/photons/edge_tree.h"
#include "renderer/photons/kernel.h"
#include "renderer/photons/neighbours.h"

namespace photond {

class Intersector;
struct Hit;
struct Scene;

/// A random number made from two.
inline uint32_t disc_turn(const vec2& u) {
    return hash32(std::bit_cast<uint32_t>(u.x) ^ hash32(std::bit_cast<uint32_t>(u.y)));
}

/// One more number in [0, 1) of a lookup with that turn.
inline float disc_lot(uint32_t turn) { return to_unit_float(hash32(turn ^ 0x51ed270bu)); }

/// Surface and photons whose geometric normal makes more than 60 degrees with that of a disc do not count on it.
inline constexpr float kDiscCosine = DISC_COSINE;

/// What an estimate's sum over a disc is divided by.
enum class DiscBoundary : uint8_t {
    None,  // the whole disc
    Clip   // the part of it that is covered
};

/// How much is asked of a disc.
enum class DiscCare : uint8_t {
    Fine,   // one that the eye sees
    Coarse  // one of many that are averaged: more noise of its own, at half of the rays
};

/// Where density is estimated.
struct CoverageDisc {
    vec3 centre;  // on a surface
    vec3 normal;  // geometric, unit, the side that is lit
    float radius_m;
    float thickness_m;
};

/// What the discs of a scene share.
class DiscCoverage {
public:
    /// For discs of at most `radius_m`. Scene and intersector are borrowed.
    DiscCoverage(const Scene& scene, const Intersector& intersector, float radius_m);

    /// False: the disc is whole, and nothing hides in it. True: a DiscProbe tells.
    bool may_be_cut(const vec3& centre, float radius_m) const { return edges_.has_edges(centre, radius_m); }
    const EdgeTree& edges() const { return edges_; }

    /// A disc's mass is not taken to be less: a needle of surface would turn one photon into a firefly.
    static constexpr float kLeastMass = DISC_LEAST_MASS;

    const Scene& scene() const { return scene_; }
    const Intersector& intersector() const { return intersector_; }
    uint64_t bytes() const { return edges_.bytes(); }

private:
    const Scene& scene_;
    const Intersector& intersector_;
    EdgeTree edges_;
};

/// What a place on a surface sees of photons about it, over folds and ledges of the surface but not through walls.
class PlaceProbe {
public:
    /// `normal`: geometric, unit. Sees at most `radius_m` far. The coverage is borrowed.
    PlaceProbe(const DiscCoverage& coverage, const vec3& place, const vec3& normal, float radius_m)
        : coverage_(coverage), place_(place), normal_(normal), radius_m_(radius_m) {}

    /// Whether the photon is seen from as high above the place as it is away, or half as high as the next surface
    /// there. True without a look where no edge is near.
    bool sees(const vec3& photon);

private:
    const DiscCoverage& coverage_;
    const vec3 place_, normal_;
    const float radius_m_;
    std::optional<float> most_lift_m_;  // once it is known
};

/// Looks one disc up.
class DiscProbe {
public:
    /// All is borrowed. `turn`, a random number, says which places are looked up. Of any radius: that of the coverage
    /// is one of its edges.
    DiscProbe(const DiscCoverage& coverage, const Kernel& kernel, const CoverageDisc& disc, uint32_t turn,
              DiscCare care);

    /// Whether a photon there counts.
    bool sees(const vec3& photon) const;

    struct Mass {
        float inverse = 1;   // an estimate of 1 / m, at most 1 / kLeastMass
        bool hides = false;  // there is surface in the disc that does not count: photons are to be asked for by sees()
    };
    Mass mass() const;

    /// Takes the photons out that the disc hides and returns one over its mass; 0 where no photon is left.
    /// `position_of(found)`: the photon's. Those found are near to one another in their order.
    template <class PositionOf>
    float clip(std::vector<Neighbours::Found>& photons, const PositionOf& position_of) const;

    static constexpr size_t kMostInBatch = DISC_FINE_BATCH;
    static constexpr size_t kMostPlaces = DISC_MOST_PLACES;

private:
    /// Photons that are asked for whether any is hidden.
    static constexpr size_t kAskedFirst = 4;

    struct Place;
    std::span<Place> look_up(uint32_t batch, std::array<Place, kMostInBatch>& places) const;
    Place place(uint32_t batch, size_t number) const;
    void look_slanted(std::span<Place> places) const;
    void look_down(std::span<Place> places) const;
    float area_over(const Hit& hit) const;

    const Scene& scene_;
    const Intersector& intersector_;
    const Kernel& kernel_;
    const CoverageDisc& disc_;
    const Frame frame_;
    const uint32_t turn_;
    const size_t batch_;  // places
    float lift_m_ = 0;
    vec3 eye_{0};  // above the centre
};

template <class PositionOf>
float DiscProbe::clip(std::vector<Neighbours::Found>& photons, const PositionOf& position_of) const {
    const auto is_hidden = [&](const Neighbours::Found& f) { return !sees(position_of(f)); };
    // A wall may stand where none of the places will be: a few photons are asked besides. Their order is one of space.
    const size_t asked = std::min(photons.size(), kAskedFirst);
    bool any_hidden = false;
    for (size_t i = 0; i < asked && !any_hidden; ++i) any_hidden = is_hidden(photons[i * photons.size() / asked]);
    if (any_hidden) std::erase_if(photons, is_hidden);
    if (photons.empty()) return 0;
    const Mass of_disc = mass();
    if (of_disc.hides && !any_hidden && asked < photons.size()) std::erase_if(photons, is_hidden);
    return of_disc.inverse;
}

}  // namespace photond
