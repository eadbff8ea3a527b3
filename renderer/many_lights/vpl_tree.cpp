#include "renderer/many_lights/vpl_tree.h"

#include <algorithm>
#include <bit>

#include "renderer/core/morton.h"
#include "renderer/core/parallel.h"
#include "renderer/core/parallel_sort.h"

namespace photond {

namespace {

constexpr VplTreeNode kNothing{vec3(kInfinity), 0, vec3(-kInfinity), 1, vec3(0), NO_VPL};

/// The axis that a normal is nearest to, 0 to 5.
uint32_t facing(const vec3& normal) {
    const vec3 a = glm::abs(normal);
    const int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
    return static_cast<uint32_t>(2 * axis) + (normal[axis] < 0 ? 1 : 0);
}

/// Of the half-angle of the cone about `axis` that holds the node's; -1 from half a turn on.
float cos_about(const vec3& axis, const VplTreeNode& node) {
    const float cos_turn = std::min(glm::dot(axis, node.axis), 1.0f);
    if (cos_turn + node.cos_cone <= 0) return -1;
    const float sines_sq = (1 - cos_turn * cos_turn) * std::max(1 - node.cos_cone * node.cos_cone, 0.0f);
    return cos_turn * node.cos_cone - std::sqrt(sines_sq);
}

}  // namespace

uint32_t vpl_tree_leaves(uint32_t lights) { return std::bit_ceil(std::max(lights, 1u)); }

float vpl_key_scale(const vec3& extent) {
    const float longest = std::max({extent.x, extent.y, extent.z});
    // Below 2^(e + 1), e its exponent.
    const int32_t exponent = std::bit_cast<int32_t>(longest) >> 23;
    const int32_t of_scale = std::min(static_cast<int32_t>(VPL_KEY_AXIS_BITS) - 1 + 254 - exponent, 254);
    return std::bit_cast<float>(of_scale << 23);
}

uint32_t vpl_key(const Vpl& vpl, const vec3& low, float scale) {
    constexpr uint32_t kLast = (1u << VPL_KEY_AXIS_BITS) - 1;
    constexpr uint32_t kFineBits = 3 * (VPL_KEY_AXIS_BITS - VPL_KEY_COARSE_BITS);
    uvec3 cell;
    for (int i = 0; i < 3; ++i) cell[i] = std::min(static_cast<uint32_t>((vpl.position[i] - low[i]) * scale), kLast);
    const uint32_t place = morton_code(cell);
    return place >> kFineBits << (kFineBits + 3) | facing(vpl.normal) << kFineBits | (place & ((1u << kFineBits) - 1));
}

VplTreeNode vpl_leaf(const Vpl& vpl, uint32_t light) {
    const float size = vpl_size(vpl);
    if (!(size > 0)) return kNothing;
    return {vpl.position, size, vpl.position, is_lambert(vpl) ? 1.0f : -1.0f, vpl.normal, light};
}

VplTreeNode merge_vpl_nodes(const VplTreeNode& a, const VplTreeNode& b) {
    if (!(a.intensity > 0) || !(b.intensity > 0)) {
        VplTreeNode node = a.intensity > 0 ? a : b;
        node.light = NO_VPL;
        return node;
    }
    VplTreeNode node{glm::min(a.low, b.low), a.intensity + b.intensity, glm::max(a.high, b.high), -1, a.axis, NO_VPL};
    if (a.axis == b.axis) {
        node.cos_cone = std::min(a.cos_cone, b.cos_cone);
        return node;
    }
    // About the axes' bisector: a cone that holds both, if not the least.
    const vec3 sum = a.axis + b.axis;
    const float length_sq = glm::dot(sum, sum);
    if (length_sq < 1e-6f) return node;
    node.axis = sum * (1 / std::sqrt(length_sq));
    node.cos_cone = std::min(cos_about(node.axis, a), cos_about(node.axis, b));
    return node;
}

void VplTree::build(std::span<const Vpl> vpls) {
    const uint32_t lights = static_cast<uint32_t>(vpls.size());
    leaves_ = vpl_tree_leaves(lights);
    Bounds3 box;
    for (const Vpl& vpl : vpls) box.extend(vpl.position);
    const float scale = lights > 0 ? vpl_key_scale(box.diagonal()) : 0.0f;
    keys_.resize(lights);
    parallel_for(lights, 4096, [&](size_t i) { keys_[i] = uint64_t{vpl_key(vpls[i], box.min, scale)} << 32 | i; });
    parallel_sort(keys_.begin(), keys_.end(), std::less<>());

    nodes_.resize(2 * size_t{leaves_});
    nodes_[0] = kNothing;
    parallel_for(leaves_, 4096, [&](size_t i) {
        const uint32_t light = i < lights ? static_cast<uint32_t>(keys_[i]) : NO_VPL;
        nodes_[leaves_ + i] = light != NO_VPL ? vpl_leaf(vpls[light], light) : kNothing;
    });
    for (size_t first = leaves_ / 2; first > 0; first /= 2)
        parallel_for(first, 4096, [&](size_t i) {
            nodes_[first + i] = merge_vpl_nodes(nodes_[2 * (first + i)], nodes_[2 * (first + i) + 1]);
        });
}

namespace {

namespace stdx = std::experimental;

/// Of the places in a box, the greatest cosine at the point between `axis` and the way there: `along` is that of the
/// box's centre, `spread` how much further along the axis the box reaches; both as lengths [m].
/// z / sqrt(z^2 + t^2) grows with z and, above 0, falls with the distance t from the axis, which the box's sphere
/// bounds; nor is it more than z over the distance to the box.
FloatLanes max_cosine(const FloatLanes& along, const FloatLanes& spread, const FloatLanes& distance_sq, float radius,
                      const FloatLanes& inverse_nearest) {
    constexpr float kRounding = 1e-6f;  // of distance_sq - along^2, over distance_sq
    const FloatLanes across_sq = distance_sq - along * along, rounding = kRounding * distance_sq;
    const FloatLanes z = along + spread;
    const FloatMask ahead = z >= 0;
    const FloatLanes nearest =
        stdx::max(stdx::sqrt(stdx::max(across_sq - rounding, FloatLanes(0))) - radius, FloatLanes(0));
    const FloatLanes farthest = stdx::sqrt(stdx::max(across_sq, FloatLanes(0)) + rounding) + radius;
    const FloatLanes t = select(ahead, nearest, farthest);
    const FloatLanes length_sq = z * z + t * t;
    const FloatLanes cosine = z / stdx::sqrt(stdx::max(length_sq, FloatLanes(1e-36f)));
    return select(ahead, stdx::min(cosine, z * inverse_nearest), cosine);
}

}  // namespace

[[gnu::flatten]] FloatLanes vpl_bound(const VplTreeNode& node, const VplReceivers& points, float clamp_sq_m2) {
    if (!(node.intensity > 0)) return 0;
    const vec3 centre = 0.5f * (node.low + node.high), half = 0.5f * (node.high - node.low);
    const float radius = std::sqrt(glm::dot(half, half));
    const Vec3Lanes d = broadcast(centre) - points.position;
    const FloatLanes distance_sq = dot(d, d);
    const Vec3Lanes gap{stdx::max(stdx::fabs(d.x) - half.x, FloatLanes(0)),
                        stdx::max(stdx::fabs(d.y) - half.y, FloatLanes(0)),
                        stdx::max(stdx::fabs(d.z) - half.z, FloatLanes(0))};
    constexpr float kLeastDistanceSq = 1e-20f;  // [m^2]: keeps bounds finite where nothing clamps
    const FloatLanes nearest_sq = stdx::max(dot(gap, gap), FloatLanes(kLeastDistanceSq));
    const FloatLanes inverse_nearest = 1.0f / stdx::sqrt(nearest_sq);

    const Vec3Lanes& n = points.normal;
    const FloatLanes spread = stdx::fabs(n.x) * half.x + stdx::fabs(n.y) * half.y + stdx::fabs(n.z) * half.z;
    const FloatLanes received = max_cosine(dot(n, d), spread, distance_sq, radius, inverse_nearest);
    const FloatMask all_sides = dot(n, n) == 0;
    FloatLanes bound = select(all_sides, FloatLanes(1), stdx::clamp(received, FloatLanes(0), FloatLanes(1)));

    if (node.cos_cone > -1) {
        const vec3& axis = node.axis;
        const FloatLanes sent = max_cosine(-dot(broadcast(axis), d), FloatLanes(glm::dot(glm::abs(axis), half)),
                                           distance_sq, radius, inverse_nearest);
        // cos(a - b) of the angle to the axis and the cone's, 1 within the cone.
        const float sin_cone = std::sqrt(std::max(1 - sqr(node.cos_cone), 0.0f));
        const FloatLanes sine = stdx::sqrt(stdx::max(1.0f - sent * sent, FloatLanes(0)));
        const FloatLanes widened = select(sent >= node.cos_cone, FloatLanes(1), sent * node.cos_cone + sine * sin_cone);
        bound *= stdx::clamp(widened, FloatLanes(0), FloatLanes(1));
    }
    return points.there * (node.intensity * bound) * (1.0f / stdx::max(nearest_sq, FloatLanes(clamp_sq_m2)));
}

}  // namespace photond
