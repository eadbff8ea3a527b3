#include "renderer/transport/shaft_visibility.h"

#include <algorithm>

#include "renderer/core/morton.h"
#include "renderer/transport/surface.h"

namespace photond {

namespace {

namespace stdx = std::experimental;
constexpr stdx::vector_aligned_tag kAligned;

constexpr uint64_t kFewTriangles = 128;  // so few need no tree
constexpr float kLargeShare = 0.4f;      // of the scene's extent: a triangle's that makes it large
constexpr size_t kMostBlocks = 24;       // that are looked at before the answer is "unknown"
constexpr size_t kMostLevels = 8;

FloatLanes lanes_of(const std::array<float, kLanes>& values) { return {values.data(), kAligned}; }
Vec3Lanes lanes_of(const std::array<float, kLanes> (&values)[3]) {
    return {lanes_of(values[0]), lanes_of(values[1]), lanes_of(values[2])};
}

}  // namespace

/// Side planes through the apex, normals outwards, and how far along the axis it reaches.
struct ShaftVisibility::Pyramid {
    vec3 apex, apex_normal, axis;
    vec3 side[4];
    float far_m;
    bool degenerate;  // the apex lies within the sphere

    Pyramid(const vec3& from, const vec3& normal, const ShaftTarget& target) : apex(from), apex_normal(normal) {
        const vec3 to = target.centre - from;
        const float distance = glm::length(to);
        degenerate = !(distance > 1.01f * target.radius_m);
        if (degenerate) return;
        axis = to / distance;
        far_m = distance + target.radius_m;
        const float sine = std::min(target.radius_m / distance * 1.0001f + 1e-6f, 1.0f);
        const float cosine = std::sqrt(1 - sine * sine);
        const Frame frame(axis);
        const vec3 across[4] = {frame.tangent, -frame.tangent, frame.bitangent, -frame.bitangent};
        for (int i = 0; i < 4; ++i) side[i] = cosine * across[i] - sine * axis;
    }
};

uint64_t ShaftVisibility::estimate_bytes(uint64_t triangles) {
    if (triangles > kMostTriangles) return 0;
    const uint64_t blocks = (triangles + kLanes - 1) / kLanes + 1;
    return blocks * sizeof(Block) + (blocks / (kLanes - 1) + 4) * sizeof(Node);
}

Bounds3 ShaftVisibility::fill(Block& block, std::span<const TriangleCorners> triangles) {
    Bounds3 bounds;
    for (size_t lane = 0; lane < kLanes; ++lane) {
        const TriangleCorners& triangle = triangles[std::min(lane, triangles.size() - 1)];
        const vec3 normal = unit_cross(triangle.p[1] - triangle.p[0], triangle.p[2] - triangle.p[0]);
        for (int axis = 0; axis < 3; ++axis) {
            for (int c = 0; c < 3; ++c) block.corner[c][axis][lane] = triangle.p[c][axis];
            block.plane[axis][lane] = normal[axis];
        }
        block.plane[3][lane] = glm::dot(normal, (triangle.p[0] + triangle.p[1] + triangle.p[2]) * (1.0f / 3));
        for (const vec3& p : triangle.p) bounds.extend(p);
    }
    return bounds;
}

ShaftVisibility::ShaftVisibility(const Scene& scene) {
    const vec3 extent = scene.bounds.diagonal();
    const float longest = std::max({extent.x, extent.y, extent.z});
    const vec3 farthest = glm::max(glm::abs(scene.bounds.min), glm::abs(scene.bounds.max));
    masked_ = scene.needs.alpha;
    tolerance_m_ = 4e-6f * std::max({farthest.x, farthest.y, farthest.z});

    const bool few = scene.triangle_count <= kFewTriangles;
    std::vector<TriangleCorners> large, small;
    std::vector<std::pair<uint32_t, uint32_t>> order;  // Morton code, index into small
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
        for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const TriangleCorners triangle = world_triangle(scene, i, t);
            Bounds3 bounds;
            for (const vec3& p : triangle.p) bounds.extend(p);
            const vec3 size = bounds.diagonal();
            if (few || std::max({size.x, size.y, size.z}) > kLargeShare * longest) {
                large.push_back(triangle);
                continue;
            }
            order.emplace_back(morton_code(scene.bounds, bounds.centre()), static_cast<uint32_t>(small.size()));
            small.push_back(triangle);
        }
    }
    std::sort(order.begin(), order.end());
    std::vector<TriangleCorners> sorted;
    sorted.reserve(small.size());
    for (const auto& [code, index] : order) sorted.push_back(small[index]);

    const auto blocks_of = [&](const std::vector<TriangleCorners>& triangles, std::vector<Bounds3>& bounds) {
        bounds.resize((triangles.size() + kLanes - 1) / kLanes);
        for (size_t b = 0; b < bounds.size(); ++b) {
            const size_t first = b * kLanes, count = std::min(kLanes, triangles.size() - first);
            bounds[b] = fill(blocks_.emplace_back(), std::span(triangles).subspan(first, count));
        }
    };
    std::vector<Bounds3> bounds;
    blocks_of(large, bounds);
    large_ = static_cast<uint32_t>(blocks_.size());
    blocks_of(sorted, bounds);
    while (!bounds.empty()) {
        std::vector<Node>& level = levels_.emplace_back((bounds.size() + kLanes - 1) / kLanes);
        std::vector<Bounds3> above(level.size());
        for (size_t i = 0; i < level.size() * kLanes; ++i) {
            // Places past the end lie where no shaft gets.
            const Bounds3 box = i < bounds.size() ? bounds[i] : Bounds3{vec3(1e30f), vec3(1e30f)};
            for (int axis = 0; axis < 3; ++axis) {
                level[i / kLanes].centre[axis][i % kLanes] = box.centre()[axis];
                level[i / kLanes].half[axis][i % kLanes] = 0.5f * box.diagonal()[axis];
            }
            if (i < bounds.size()) above[i / kLanes].extend(box);
        }
        if (level.size() == 1) break;
        bounds.swap(above);
    }
}

uint64_t ShaftVisibility::bytes() const {
    uint64_t nodes = 0;
    for (const std::vector<Node>& level : levels_) nodes += level.size();
    return blocks_.size() * sizeof(Block) + nodes * sizeof(Node);
}

/// Goes down to the blocks whose nodes `children_of` (a mask of a node's children) lets through. True as soon as
/// `in_block` is, or when it takes too long.
template <class Children, class Leaf>
bool ShaftVisibility::any(const Children& children_of, const Leaf& in_block) const {
    for (uint32_t block = 0; block < large_; ++block)
        if (in_block(block)) return true;
    if (levels_.empty()) return false;
    struct Place {
        uint32_t level, index;  // of a node
    };
    std::array<Place, kMostLevels * kLanes> stack;
    size_t depth = 0;
    stack[depth++] = {static_cast<uint32_t>(levels_.size()) - 1, 0};
    for (size_t blocks = 0; depth > 0;) {
        const auto [level, index] = stack[--depth];
        const FloatMask mask = children_of(levels_[level][index]);
        if (stdx::none_of(mask)) continue;
        for (uint32_t lane = 0; lane < kLanes; ++lane) {
            if (!mask[lane]) continue;
            const uint32_t child = index * static_cast<uint32_t>(kLanes) + lane;
            if (level > 0) {
                stack[depth++] = {level - 1, child};
            } else if (++blocks > kMostBlocks || in_block(large_ + child)) {
                return true;
            }
        }
    }
    return false;
}

// Flattened: the compiler stops inlining lanes' arithmetic here, which doubles the time.
[[gnu::flatten]] FloatMask ShaftVisibility::block_in_shaft(const Block& block, const Pyramid& pyramid,
                                                           const ShaftTarget& target) const {
    // Relative to the apex.
    const Vec3Lanes apex = broadcast(pyramid.apex);
    const Vec3Lanes a = lanes_of(block.corner[0]) - apex, b = lanes_of(block.corner[1]) - apex,
                    c = lanes_of(block.corner[2]) - apex;
    FloatMask outside(false);
    for (const vec3& side : pyramid.side) {
        const Vec3Lanes n = broadcast(side);
        outside = outside || stdx::min(stdx::min(dot(n, a), dot(n, b)), dot(n, c)) > 0;
    }
    const Vec3Lanes axis = broadcast(pyramid.axis);
    const FloatLanes along_a = dot(axis, a), along_b = dot(axis, b), along_c = dot(axis, c);
    outside = outside || stdx::max(stdx::max(along_a, along_b), along_c) < 0 ||
              stdx::min(stdx::min(along_a, along_b), along_c) > pyramid.far_m;
    // All below the apex's horizon, or behind the target's plane.
    const FloatLanes tolerance = tolerance_m_;
    const auto highest = [&](const vec3& normal) {
        const Vec3Lanes n = broadcast(normal);
        return stdx::max(stdx::max(dot(n, a), dot(n, b)), dot(n, c));
    };
    outside = outside || highest(pyramid.apex_normal) <= tolerance;
    if (target.flat())
        outside =
            outside || highest(target.normal) <= glm::dot(target.normal, target.centre - pyramid.apex) + tolerance;
    if (stdx::all_of(outside)) return !outside;

    const Vec3Lanes n{lanes_of(block.plane[0]), lanes_of(block.plane[1]), lanes_of(block.plane[2])};
    const FloatLanes offset = lanes_of(block.plane[3]);
    const FloatLanes of_apex = dot(n, apex) - offset, of_centre = dot(n, broadcast(target.centre)) - offset;
    FloatLanes reach =
        stdx::fabs(n.x) * target.half.x + stdx::fabs(n.y) * target.half.y + stdx::fabs(n.z) * target.half.z;
    if (target.flat()) {  // a disc: along n it reaches as far as the sine of the planes' angle says
        const Vec3Lanes sine = cross(n, broadcast(target.normal));
        reach = stdx::min(reach, target.radius_m * stdx::sqrt(dot(sine, sine)));
    }
    outside = outside || (of_apex >= -tolerance && of_centre - reach >= -tolerance) ||
              (of_apex <= tolerance && of_centre + reach <= tolerance);
    return !outside;
}

ShaftVisibility::Block ShaftVisibility::gather(std::span<const uint32_t> triangles) const {
    Block block;
    for (size_t lane = 0; lane < kLanes; ++lane) {
        const uint32_t triangle = triangles[std::min(lane, triangles.size() - 1)];
        const Block& from = blocks_[triangle / kLanes];
        const size_t place = triangle % kLanes;
        for (int axis = 0; axis < 3; ++axis) {
            for (int c = 0; c < 3; ++c) block.corner[c][axis][lane] = from.corner[c][axis][place];
            block.plane[axis][lane] = from.plane[axis][place];
        }
        block.plane[3][lane] = from.plane[3][place];
    }
    return block;
}

ShaftBlockers ShaftVisibility::blockers(const vec3& apex, const vec3& apex_normal, const ShaftTarget& target,
                                        const ShaftBlockers& within) const {
    const Pyramid pyramid(apex, apex_normal, target);
    // A bent target's own triangles stand in its shaft: where they are small that is too many of them.
    if (pyramid.degenerate || (!target.flat() && !levels_.empty() && !within.known())) return within;
    ShaftBlockers found;
    if (within.known()) {
        for (uint32_t first = 0; first < within.count; first += uint32_t{kLanes}) {
            const uint32_t lanes = std::min(within.count - first, uint32_t{kLanes});
            const FloatMask in =
                block_in_shaft(gather(std::span(within.triangles).subspan(first, lanes)), pyramid, target);
            for (uint32_t lane = 0; lane < lanes; ++lane)
                if (in[lane]) found.triangles[found.count++] = within.triangles[first + lane];
        }
        return found;
    }
    const auto children_of = [&](const Node& node) {
        const Vec3Lanes centre = lanes_of(node.centre) - broadcast(apex), half = lanes_of(node.half);
        FloatMask outside(false);
        for (const vec3& side : pyramid.side)
            outside = outside || dot(broadcast(side), centre) - dot(broadcast(glm::abs(side)), half) > 0;
        const FloatLanes along = dot(broadcast(pyramid.axis), centre);
        const FloatLanes reach = dot(broadcast(glm::abs(pyramid.axis)), half);
        return !(outside || along + reach < 0 || along - reach > pyramid.far_m);
    };
    const bool too_many = any(children_of, [&](uint32_t block) {
        const FloatMask in = block_in_shaft(blocks_[block], pyramid, target);
        if (stdx::none_of(in)) return false;
        for (uint32_t lane = 0; lane < kLanes; ++lane) {
            if (!in[lane]) continue;
            if (masked_ || found.count == ShaftBlockers::kMost) return true;
            found.triangles[found.count++] = block * static_cast<uint32_t>(kLanes) + lane;
        }
        return false;
    });
    return too_many ? ShaftBlockers::unknown() : found;
}

/// [Moeller and Trumbore 1997] Fast, Minimum Storage Ray/Triangle Intersection.
[[gnu::flatten]] FloatMask ShaftVisibility::blocked(std::span<const uint32_t> triangles, const Vec3Lanes& from,
                                                    const vec3& to) const {
    const Vec3Lanes direction = broadcast(to) - from;
    FloatMask cut(false);
    for (const uint32_t triangle : triangles) {
        const Block& block = blocks_[triangle / kLanes];
        const size_t place = triangle % kLanes;
        const auto corner = [&](int c) {
            return vec3(block.corner[c][0][place], block.corner[c][1][place], block.corner[c][2][place]);
        };
        const vec3 origin = corner(0);
        const Vec3Lanes edge1 = broadcast(corner(1) - origin), edge2 = broadcast(corner(2) - origin);
        const Vec3Lanes p = cross(direction, edge2), s = from - broadcast(origin), q = cross(s, edge1);
        const FloatLanes inverse = 1.0f / dot(edge1, p);
        const FloatLanes u = dot(s, p) * inverse, v = dot(direction, q) * inverse, t = dot(edge2, q) * inverse;
        cut = cut || (u >= 0 && v >= 0 && u + v <= 1 && t > 0 && t < 1);
    }
    return cut;
}

bool ShaftVisibility::near_above(const ShaftTarget& target, float radius_m, const vec3& point,
                                 const vec3& normal) const {
    const Vec3Lanes centre = broadcast(target.centre);
    const vec3 reach = target.half + vec3(radius_m);
    const float offset = glm::dot(normal, point);
    const auto children_of = [&](const Node& node) {
        const Vec3Lanes between = lanes_of(node.centre) - centre, half = lanes_of(node.half);
        return stdx::fabs(between.x) <= half.x + reach.x && stdx::fabs(between.y) <= half.y + reach.y &&
               stdx::fabs(between.z) <= half.z + reach.z;
    };
    return any(children_of, [&](uint32_t index) {
        const Block& block = blocks_[index];
        const Vec3Lanes corner[3] = {lanes_of(block.corner[0]), lanes_of(block.corner[1]), lanes_of(block.corner[2])};
        const auto least = [&](auto get) {
            return stdx::min(stdx::min(get(corner[0]), get(corner[1])), get(corner[2]));
        };
        const auto most = [&](auto get) {
            return stdx::max(stdx::max(get(corner[0]), get(corner[1])), get(corner[2]));
        };
        const auto apart = [&](int axis, auto get) {
            return least(get) > target.centre[axis] + reach[axis] || most(get) < target.centre[axis] - reach[axis];
        };
        const FloatMask away =
            apart(0, [](const Vec3Lanes& v) { return v.x; }) || apart(1, [](const Vec3Lanes& v) { return v.y; }) ||
            apart(2, [](const Vec3Lanes& v) { return v.z; }) ||
            most([&](const Vec3Lanes& v) { return dot(broadcast(normal), v); }) <= offset + tolerance_m_;
        return !stdx::all_of(away);
    });
}

}  // namespace photond
