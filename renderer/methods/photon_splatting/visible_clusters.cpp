#include "renderer/methods/photon_splatting/visible_clusters.h"

#include <algorithm>

#include "renderer/core/morton.h"

namespace photond {

namespace {

constexpr uint32_t kBlockSide = 16;  // pixels
constexpr float kNowhere = 1e18f;    // coordinates no splat reaches, whose squares are finite

const vec3& position_of(const LambertVisiblePoint& point) { return point.position; }
const vec3& position_of(const VisiblePoint& point) { return point.surface.position; }
const vec3& geometric_normal_of(const LambertVisiblePoint& point) { return point.geometric_normal; }
const vec3& geometric_normal_of(const VisiblePoint& point) { return point.surface.geometric_normal; }
/// Zero where light from both sides is scattered.
vec3 normal_of(const LambertVisiblePoint& point) { return point.normal; }
vec3 normal_of(const VisiblePoint& point) {
    return point.rough.has_non_delta_transmission() ? vec3(0) : point.surface.shading.normal;
}
Rgb weight_of(const LambertVisiblePoint& point) { return point.weight * kInvPi; }
Rgb weight_of(const VisiblePoint& point) { return point.throughput; }

template <class Point>
constexpr bool kGeneral = std::is_same_v<Point, VisiblePoint>;

/// Normals of coplanar triangles, which differ by rounding.
bool alike(const vec3& a, const vec3& b) { return glm::dot(a - b, a - b) < 1e-12f; }

/// Of several targets together.
ShaftTarget target_of(std::span<const ShaftTarget> children) {
    Bounds3 box;
    for (const ShaftTarget& child : children) {
        box.extend(child.centre - child.half);
        box.extend(child.centre + child.half);
    }
    const vec3 normal = children[0].normal;
    bool flat = children[0].flat();
    dvec3 sum(0);
    for (const ShaftTarget& child : children) {
        const float scale = max_component(glm::abs(child.centre) + box.diagonal());
        flat &= alike(child.normal, normal) &&
                std::fabs(glm::dot(child.centre - children[0].centre, normal)) <= SPLAT_OFF_PLANE * scale;
        sum += dvec3(child.centre);
    }
    const vec3 centre = flat ? vec3(sum / static_cast<double>(children.size())) : box.centre();
    ShaftTarget target{centre, glm::max(box.max - centre, centre - box.min), 0, flat ? normal : vec3(0)};
    for (const ShaftTarget& child : children)
        target.radius_m = std::max(target.radius_m, glm::length(child.centre - centre) + child.radius_m);
    target.radius_m = std::min(target.radius_m, glm::length(target.half)) * 1.0001f;
    return target;
}

}  // namespace

void ClusterBuilder::start(const Tile& tile, uint32_t tile_index, Size2 film_size, uint32_t max_scatterings,
                           float split_extent_m, PointTile& points, std::vector<VisibleCluster>& clusters) {
    tile_ = tile;
    tile_index_ = tile_index;
    width_ = film_size.width;
    max_scatterings_ = max_scatterings;
    split_extent_m_ = split_extent_m;
    points_ = &points;
    clusters_ = &clusters;
    points.blocks.clear();
    points.general.clear();
}

void ClusterBuilder::take(std::span<const LambertVisiblePoint> lambert, std::span<const VisiblePoint> others) {
    take_kind(lambert);
    take_kind(others);
}

/// Sorts the points by the number of their path's scatterings and by block of pixels.
template <class Point>
void ClusterBuilder::take_kind(std::span<const Point> points) {
    if (points.empty()) return;
    const uint32_t columns = (tile_.x1 - tile_.x0 + kBlockSide - 1) / kBlockSide;
    const uint32_t rows = (tile_.y1 - tile_.y0 + kBlockSide - 1) / kBlockSide;
    uint32_t least = ~0u, most = 0;
    for (const Point& point : points) {
        least = std::min(least, point.scatterings);
        most = std::max(most, point.scatterings);
    }
    // A path of hundreds of scatterings is one in a million: those are all sorted together.
    const uint32_t kinds = std::min(most - least, 63u) + 1;
    const auto key = [&](const Point& point) {
        const uint32_t x = point.pixel % width_ - tile_.x0, y = point.pixel / width_ - tile_.y0;
        return (std::min(point.scatterings - least, kinds - 1) * rows + y / kBlockSide) * columns + x / kBlockSide;
    };
    counts_.assign(size_t{kinds} * rows * columns + 1, 0);
    keys_.resize(points.size());
    for (size_t i = 0; i < points.size(); ++i) {
        keys_[i] = key(points[i]);
        ++counts_[keys_[i] + 1];
    }
    for (size_t i = 1; i < counts_.size(); ++i) counts_[i] += counts_[i - 1];
    order_.resize(points.size());
    for (uint32_t i = 0; i < points.size(); ++i) order_[counts_[keys_[i]]++] = i;
    size_t first = 0;
    for (size_t k = 0; k + 1 < counts_.size(); ++k) {  // counts_[k] is now the end of block k
        if (counts_[k] > first) add_cluster(points, std::span(order_).subspan(first, counts_[k] - first));
        first = counts_[k];
    }
}

template <class Point>
void ClusterBuilder::add_cluster(std::span<const Point> points, std::span<uint32_t> order) {
    Bounds3 box;
    for (const uint32_t i : order) box.extend(position_of(points[i]));
    const vec3 extent = box.diagonal();
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const bool many = order.size() > VisibleCluster::kMostPoints;
    if (many || (order.size() > kLanes && extent[axis] > split_extent_m_)) {
        const float middle = box.centre()[axis];
        auto cut = std::partition(order.begin(), order.end(),
                                  [&](uint32_t i) { return position_of(points[i])[axis] < middle; });
        if (cut == order.begin() || cut == order.end()) cut = order.begin() + std::ptrdiff_t(order.size() / 2);
        const auto lower = static_cast<size_t>(cut - order.begin());
        add_cluster(points, order.first(lower));
        add_cluster(points, order.subspan(lower));
        return;
    }

    VisibleCluster cluster;
    cluster.tile = tile_index_;
    cluster.first_block = static_cast<uint32_t>(points_->blocks.size());
    cluster.points = static_cast<uint16_t>(order.size());
    cluster.general = kGeneral<Point>;
    uint32_t most_before = 0;
    const vec3 normal = geometric_normal_of(points[order[0]]);
    bool flat = true;
    dvec3 sum(0);
    for (const uint32_t i : order) {
        const Point& point = points[i];
        most_before = std::max(most_before, point.scatterings);
        flat &= alike(geometric_normal_of(point), normal) && alike(normal_of(point), normal);
        sum += dvec3(position_of(point));
    }
    // The mean of points on a plane is on it, which the box's centre is not.
    const vec3 centre = flat ? vec3(sum / static_cast<double>(order.size())) : box.centre();
    float radius_sq = 0, off_plane = 0;
    for (const uint32_t i : order) {
        const vec3 from_centre = position_of(points[i]) - centre;
        radius_sq = std::max(radius_sq, glm::dot(from_centre, from_centre));
        off_plane = std::max(off_plane, std::fabs(glm::dot(from_centre, normal)));
    }
    flat &= off_plane <= SPLAT_OFF_PLANE * max_component(glm::abs(centre) + box.diagonal());
    cluster.target = {centre, glm::max(box.max - centre, centre - box.min), std::sqrt(radius_sq) * 1.0001f,
                      flat ? normal : vec3(0)};
    cluster.most_scatterings = max_scatterings_ - std::min(max_scatterings_, most_before + 1);

    for (size_t first = 0; first < order.size(); first += kLanes) {
        PointBlock& block = points_->blocks.emplace_back();
        for (size_t lane = 0; lane < kLanes; ++lane) {
            const Point& point = points[order[std::min(first + lane, order.size() - 1)]];
            block.position.set(lane, first + lane < order.size() ? position_of(point) : vec3(kNowhere));
            block.normal.set(lane, normal_of(point));
            block.geometric_normal.set(lane, geometric_normal_of(point));
            block.weight.set(lane, weight_of(point));
            block.sum.set(lane, vec3(0));
            block.splats[lane] = block.splat_weight[lane] = 0;
            block.pixel[lane] = point.pixel;
            block.general[lane] = 0;
            if constexpr (kGeneral<Point>) {
                if (first + lane >= order.size()) continue;
                block.general[lane] = static_cast<uint32_t>(points_->general.size());
                points_->general.push_back(point);
            }
        }
    }
    clusters_->push_back(cluster);
}

void VisibleClusters::build(std::vector<VisibleCluster> clusters, const Bounds3& bounds) {
    std::vector<uint64_t> order(clusters.size());
    for (size_t i = 0; i < clusters.size(); ++i)
        order[i] = uint64_t{morton_code(bounds, clusters[i].target.centre)} << 32 | i;
    std::sort(order.begin(), order.end());
    clusters_.resize(clusters.size());
    for (size_t i = 0; i < order.size(); ++i) clusters_[i] = clusters[order[i] & 0xffff'ffffu];

    levels_.clear();
    std::vector<ShaftTarget> children;
    std::vector<float> splat_radii_m;  // of the children
    children.reserve(clusters_.size()), splat_radii_m.reserve(clusters_.size());
    for (const VisibleCluster& cluster : clusters_) {
        children.push_back(cluster.target);
        splat_radii_m.push_back(cluster.splat_radius_m);
    }
    while (!children.empty()) {
        Level& level = levels_.emplace_back();
        level.children = children.size();
        level.nodes.resize((children.size() + kLanes - 1) / kLanes);
        level.targets.resize(level.nodes.size());
        level.splat_radii_m.assign(level.nodes.size(), 0.0f);
        for (size_t n = 0; n < level.nodes.size(); ++n) {
            Node& node = level.nodes[n];
            const size_t first = n * kLanes, last = std::min(first + kLanes, children.size());
            level.targets[n] = target_of(std::span(children).subspan(first, last - first));
            for (size_t lane = 0; lane < kLanes; ++lane) {
                const ShaftTarget& child = children[std::min(first + lane, last - 1)];
                node.x[lane] = child.centre.x, node.y[lane] = child.centre.y, node.z[lane] = child.centre.z;
                node.radius[lane] = child.radius_m;
                node.splat_radius[lane] = splat_radii_m[std::min(first + lane, last - 1)];
                level.splat_radii_m[n] = std::max(level.splat_radii_m[n], node.splat_radius[lane]);
            }
        }
        if (level.nodes.size() == 1) break;
        children = level.targets;
        splat_radii_m = level.splat_radii_m;
    }
}

uint64_t VisibleClusters::bytes() const {
    uint64_t bytes = clusters_.capacity() * sizeof(VisibleCluster);
    for (const Level& level : levels_)
        bytes += level.nodes.capacity() * sizeof(Node) + level.targets.capacity() * sizeof(ShaftTarget);
    return bytes;
}

}  // namespace photond
