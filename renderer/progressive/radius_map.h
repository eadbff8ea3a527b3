#pragma once
// Radii as a function of place: means over the leaves of a kd-tree of places where they are known.

#include <span>
#include <vector>

#include "renderer/core/geometry.h"
#include "renderer/progressive/radius_map_shared.h"

namespace photond {

/// A radius that is known at a place.
struct PlacedRadius {
    vec3 position;   // world [m]
    float radius_m;  // > 0
};

class RadiusMap {
public:
    RadiusMap() = default;
    /// `otherwise_m`: where there is no place.
    RadiusMap(std::vector<PlacedRadius> places, float otherwise_m);

    /// The geometric mean of the radii about p. `turn`, a random number, moves p by up to a leaf's width, so that the
    /// mean of many has no steps where leaves meet.
    float radius_m(const vec3& p, uint32_t turn) const;
    float most_m() const { return most_m_; }
    /// Half of the leaves have less.
    float median_m() const;
    uint64_t bytes() const { return nodes_.capacity() * sizeof(Node) + leaves_.capacity() * sizeof(Leaf); }
    /// At most, of so many places, what its building takes for a while included.
    static uint64_t bytes_for(uint64_t places);

    /// For the twin in radius_map.glsl: the nodes, and the leaves behind them, a record of 16 bytes each.
    std::vector<gpu::RadiusMapRecord> device_records() const;
    uint32_t device_leaves() const { return static_cast<uint32_t>(nodes_.size()); }  // the first leaf's record

    /// Places of a leaf, at most.
    static constexpr size_t kLeafPlaces = 12;

private:
    struct Node {
        float plane;    // points left of it have coordinates below
        uint32_t axis;  // 3: a leaf
        uint32_t left;  // node; of a leaf: its number
        uint32_t right;
    };
    struct Leaf {
        float radius_m;
        vec3 width_m;  // of the box of its places
    };
    uint32_t build(std::span<PlacedRadius> places);
    const Leaf& leaf_at(const vec3& p) const;

    std::vector<Node> nodes_;
    std::vector<Leaf> leaves_;
    float most_m_ = 0;
};

}  // namespace photond
