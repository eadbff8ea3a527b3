#pragma once
// The visible points of a pass, in clusters that are near in space and face alike as far as the image does, and a tree
// over them: splats find the points about a photon's ray without looking at the rest of the image.
//
// Points come tile by tile from the walk (specular_walk.h). Blocks of 16x16 pixels become clusters; where a block is
// wider than splats care for (silhouettes, grazing floors) it is halved by place. Clusters lie along a Morton curve,
// and kLanes in a row make a node, whose bounding spheres are tested at once.

#include <span>
#include <vector>

#include "renderer/core/lanes.h"
#include "renderer/eye/specular_walk.h"
#include "renderer/eye/visible_point.h"
#include "renderer/methods/photon_splatting/splat_shared.h"
#include "renderer/transport/lambert_lanes.h"
#include "renderer/transport/shaft_visibility.h"

namespace photond {

/// kLanes visible points side by side. Places past a cluster's end lie where no splat reaches.
struct PointBlock {
    PointBlock() {}  // NOLINT(modernize-use-equals-default): not zeroed, all of it is written

    Vec3Array position;          // world [m]
    Vec3Array normal;            // that shades; 0 where light from both sides counts
    Vec3Array geometric_normal;  // on the eye's side
    Vec3Array weight;            // Lambert: throughput times reflectance / pi; others: throughput
    Vec3Array sum;               // of the splats: Lambert irradiance [W m^-2], others radiance [W m^-2 sr^-1]
    alignas(kLaneAlignment) LaneFloats splats;        // that reach the point
    alignas(kLaneAlignment) LaneFloats splat_weight;  // `normalised`: sum of the filter's weights
    uint32_t pixel[kLanes];
    uint32_t general[kLanes];  // index into PointTile::general
};

/// The points of one tile of the image. Kept from pass to pass for its memory.
struct PointTile {
    std::vector<PointBlock> blocks;
    std::vector<VisiblePoint> general;
};

struct VisibleCluster {
    static constexpr uint32_t kMostPoints = 256;

    ShaftTarget target;  // its points' box and sphere; its normal is theirs where the cluster is flat
    uint32_t tile = 0;
    uint32_t first_block = 0;
    uint16_t points = 0;
    bool general = false;           // not Lambert
    float splat_radius_m = 0;       // of connections that light these points
    uint32_t most_scatterings = 0;  // of a photon that may light it: the rest is the eye path's

    /// One geometric normal, on the eye's side, which is the shading normal too.
    bool flat() const { return target.flat(); }
    /// B of connections to these points (connect_weight.h) [m^2]: what comes from nearer is found by short rays. At a
    /// sixth of the radius the noise of those, one a pixel, is about as small as that of the splats.
    float clamp_sq_m2() const { return sqr(SPLAT_CLAMP_SHARE * splat_radius_m); }
    uint32_t blocks() const { return (points + uint32_t{kLanes} - 1) / uint32_t{kLanes}; }
};

/// Puts one tile's points into clusters; scratch of one thread.
class ClusterBuilder final : public VisiblePointSink {
public:
    /// `split_extent_m`: clusters wider than that are halved, down to kLanes points.
    void start(const Tile& tile, uint32_t tile_index, Size2 film_size, uint32_t max_scatterings, float split_extent_m,
               PointTile& points, std::vector<VisibleCluster>& clusters);
    void take(std::span<const LambertVisiblePoint> lambert, std::span<const VisiblePoint> others) override;

private:
    template <class Point>
    void take_kind(std::span<const Point> points);
    template <class Point>
    void add_cluster(std::span<const Point> points, std::span<uint32_t> order);

    Tile tile_{};
    uint32_t tile_index_ = 0, width_ = 0, max_scatterings_ = 0;
    float split_extent_m_ = 0;
    PointTile* points_ = nullptr;
    std::vector<VisibleCluster>* clusters_ = nullptr;
    std::vector<uint32_t> order_, keys_, counts_;
};

class VisibleClusters {
public:
    /// Tree over the clusters, which are moved in with their splat radii; their order changes.
    void build(std::vector<VisibleCluster> clusters, const Bounds3& bounds);

    std::span<const VisibleCluster> clusters() const { return clusters_; }
    uint64_t bytes() const;

    /// A segment of a ray and all points nearer to it than `radius_m` plus `radius` times their cluster's splat radius;
    /// `far_m` may be infinite. Distances before its near end are those from that end.
    struct Beam {
        vec3 origin, axis;  // axis unit
        float near_m = 0, far_m = kInfinity, radius_m = 0, radius = 0;
    };

    /// Calls leaf(cluster index, state) for all clusters whose sphere a beam may reach, in an order that depends on
    /// nothing else. Going down, enter(target, state) says for each node, and for each cluster before leaf(), what it
    /// makes of what its parent's said; a negative state leaves it out.
    template <class Enter, class Leaf>
    void find(const Beam& beam, int state, const Enter& enter, const Leaf& leaf) const;

private:
    struct Node {
        alignas(kLaneAlignment) LaneFloats x, y, z, radius;  // spheres of the children
        alignas(kLaneAlignment) LaneFloats splat_radius;     // greatest of each
    };
    struct Level {
        std::vector<Node> nodes;
        std::vector<ShaftTarget> targets;  // of the nodes themselves
        std::vector<float> splat_radii_m;
        size_t children = 0;  // in all
    };

    std::vector<VisibleCluster> clusters_;
    std::vector<Level> levels_;  // levels_[0]: children are clusters
};

template <class Enter, class Leaf>
void VisibleClusters::find(const Beam& beam, int state, const Enter& enter, const Leaf& leaf) const {
    namespace stdx = std::experimental;
    constexpr stdx::vector_aligned_tag kAligned;
    if (levels_.empty()) return;
    struct Place {
        uint32_t level, index;
        int state;
    };
    constexpr size_t kMostLevels = 10;
    std::array<Place, kMostLevels * kLanes> stack;
    size_t depth = 0;
    stack[depth++] = {static_cast<uint32_t>(levels_.size()) - 1, 0, state};
    const Vec3Lanes origin = broadcast(beam.origin), axis = broadcast(beam.axis);
    while (depth > 0) {
        const auto [level, index, from] = stack[--depth];
        const Level& here = levels_[level];
        const int mine = enter(here.targets[index], from);
        if (mine < 0) continue;
        const Node& node = here.nodes[index];
        const Vec3Lanes d =
            Vec3Lanes{FloatLanes(node.x, kAligned), FloatLanes(node.y, kAligned), FloatLanes(node.z, kAligned)} -
            origin;
        const FloatLanes t = stdx::min(stdx::max(dot(d, axis), FloatLanes(beam.near_m)), FloatLanes(beam.far_m));
        const Vec3Lanes across = d - t * axis;
        const FloatLanes reach =
            FloatLanes(node.radius, kAligned) + beam.radius * FloatLanes(node.splat_radius, kAligned) + beam.radius_m;
        const FloatMask near = dot(across, across) <= reach * reach;
        if (stdx::none_of(near)) continue;
        const uint32_t first = index * static_cast<uint32_t>(kLanes);
        const size_t children = std::min(kLanes, here.children - first);
        for (uint32_t lane = 0; lane < children; ++lane) {
            if (!near[lane]) continue;
            if (level > 0) {
                stack[depth++] = {level - 1, first + lane, mine};
                continue;
            }
            const int at_cluster = enter(clusters_[first + lane].target, mine);
            if (at_cluster >= 0) leaf(first + lane, at_cluster);
        }
    }
}

}  // namespace photond
