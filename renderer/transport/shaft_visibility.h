#pragma once
// Whether anything may stand between a point and a small region: one question instead of a shadow ray to each of the
// region's points. After shaft culling [Haines and Wallace 1991], conservative: "clear" is exact, all else is unknown.
//
// The shaft is the pyramid from the apex about the region's bounding sphere. A triangle cannot stand in it when it lies
// outside one of the pyramid's planes, or when apex and region lie on one side of its own plane: so the walls of a
// convex room never do, whatever lies on them.
//
// [Haines and Wallace 1991] Shaft Culling for Efficient Ray-Traced Radiosity. Eurographics Workshop on Rendering.

#include <array>
#include <span>
#include <vector>

#include "renderer/core/lanes.h"
#include "renderer/scene/scene.h"

namespace photond {

/// Where shafts end: points within a box and a sphere, and on a plane where there is one.
struct ShaftTarget {
    vec3 centre{0};  // of both, and on the plane
    vec3 half{0};    // of the box
    float radius_m = 0;
    vec3 normal{0};  // unit, of the plane; 0: none

    bool flat() const { return normal != vec3(0); }
};

/// Triangles that may stand in a shaft.
struct ShaftBlockers {
    static constexpr uint32_t kMost = 16;
    uint32_t count = 0;  // kMost + 1: more than that; nothing more is known
    std::array<uint32_t, kMost> triangles;

    bool known() const { return count <= kMost; }
    static ShaftBlockers unknown() {
        ShaftBlockers all;
        all.count = kMost + 1;
        return all;
    }
};

class ShaftVisibility {
public:
    /// Scenes with more triangles than that are left to shadow rays: the copy made here costs 52 bytes a triangle.
    static constexpr uint64_t kMostTriangles = 2'000'000;
    static uint64_t estimate_bytes(uint64_t triangles);

    /// All triangles of a finished scene, which is not needed any more.
    explicit ShaftVisibility(const Scene& scene);

    /// Triangles that may cut segments from the apex to points of the target; none: all are free. The apex lies on a
    /// surface, the points may: only segments count that leave to the side that `apex_normal` (unit) shows to, and
    /// reach a flat target on the side of its normal. `within`: what was said of a target that holds this one, seen
    /// from the same apex. Where a surface is masked, or it would take long, the answer is unknown. Thread-safe.
    ShaftBlockers blockers(const vec3& apex, const vec3& apex_normal, const ShaftTarget& target,
                           const ShaftBlockers& within = ShaftBlockers::unknown()) const;

    /// Which of the segments between the points and `to`, both off their surfaces, are cut by these triangles.
    FloatMask blocked(std::span<const uint32_t> triangles, const Vec3Lanes& from, const vec3& to) const;

    /// Whether a triangle may come within `radius_m` of the target's points on the side of the plane through `point`
    /// that `normal` (unit) shows to. False is exact.
    bool near_above(const ShaftTarget& target, float radius_m, const vec3& point, const vec3& normal) const;

    uint64_t bytes() const;

private:
    struct Block {  // kLanes triangles; places past the end are never in a shaft
        alignas(kLaneAlignment) std::array<float, kLanes> corner[3][3];  // by corner and axis
        alignas(kLaneAlignment)
            std::array<float, kLanes> plane[4];  // unit normal and offset: n . p = offset on the triangle
    };
    struct Node {  // kLanes children
        alignas(kLaneAlignment) std::array<float, kLanes> centre[3], half[3];
    };
    struct Pyramid;

    static Bounds3 fill(Block& block, std::span<const TriangleCorners> triangles);
    FloatMask block_in_shaft(const Block& block, const Pyramid& pyramid, const ShaftTarget& target) const;
    Block gather(std::span<const uint32_t> triangles) const;
    template <class Children, class Leaf>
    bool any(const Children& children_of, const Leaf& in_block) const;

    std::vector<Block> blocks_;              // first the large triangles, which no box but the scene's holds well
    uint32_t large_ = 0;                     // blocks of those: always asked; the others lie along a Morton curve
    std::vector<std::vector<Node>> levels_;  // levels_[0] has the other blocks as children
    bool masked_ = false;                    // some triangle lets part of the light through
    float tolerance_m_ = 0;                  // how far a point of a surface may lie off its plane by rounding
};

}  // namespace photond
