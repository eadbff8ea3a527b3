#include "renderer/voxels/svo_march.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace photond {

namespace {

using glm::ivec3;

/// A brick's bit of a voxel.
uint32_t bit_in_brick(const ivec3& voxel) {
    return static_cast<uint32_t>((voxel.x & 3) | (voxel.y & 3) << 2 | (voxel.z & 3) << 4);
}

bool has_bit(const gpu::SvoBrick& brick, const ivec3& voxel) {
    const uint32_t bit = bit_in_brick(voxel);
    return brick.mask[bit / 32] >> bit % 32 & 1;
}

/// The leaf that holds a voxel: a brick's place, or SVO_NO_DATA for an empty box of `size` voxels.
uint32_t find_leaf(const SvoView& tree, const ivec3& voxel, int32_t& size) {
    uint32_t tile = 0;
    int shift = std::countr_zero(tree.constants.grid.resolution) - 1;
    for (uint32_t level = 1;; ++level, --shift) {
        const auto child =
            static_cast<uint32_t>((voxel.x >> shift & 1) | (voxel.y >> shift & 1) << 1 | (voxel.z >> shift & 1) << 2);
        const gpu::SvoNode& node = tree.nodes[size_t{tile} * 8 + child];
        if (!(node.info & SVO_FLAGGED) || level == tree.constants.levels) {
            size = 1 << shift;
            return node.data;
        }
        tile = node.info & SVO_TILE_MASK;
    }
}

bool is_finite(const vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

/// From floats that are no less than 0 or no more than the resolution, cut to the range.
ivec3 voxel_at(const vec3& p, const ivec3& low, const ivec3& high) {
    return glm::clamp(ivec3(glm::floor(glm::clamp(p, vec3(-1), vec3(VOXEL_MOST_RESOLUTION)))), low, high);
}

struct SetVoxel {
    float t;
    ivec3 voxel;
    uint32_t brick;
};

/// The first set voxel that origin + t direction [voxels] lies in, for t in [t_begin, t_end).
bool march(const SvoView& tree, const vec3& origin, const vec3& direction, float t_begin, float t_end, SetVoxel& hit) {
    if (!is_finite(origin) || !is_finite(direction)) return false;
    const auto resolution = static_cast<int32_t>(tree.constants.grid.resolution);
    constexpr float kLeast = 1e-20f;
    vec3 inverse;
    bool forward[3];
    for (int i = 0; i < 3; ++i) {
        const float d = direction[i];
        inverse[i] = 1 / (std::fabs(d) < kLeast ? std::copysign(kLeast, d) : d);
        forward[i] = inverse[i] > 0;
    }
    const vec3 to_low = -origin * inverse, to_high = (vec3(static_cast<float>(resolution)) - origin) * inverse;
    const vec3 enter = glm::min(to_low, to_high), leave = glm::max(to_low, to_high);
    float t = std::max({t_begin, enter.x, enter.y, enter.z});
    t_end = std::min({t_end, leave.x, leave.y, leave.z});
    if (!(t < t_end)) return false;

    ivec3 voxel = voxel_at(origin + t * direction, ivec3(0), ivec3(resolution - 1));
    for (int32_t turns = 0; turns < 3 * resolution; ++turns) {
        int32_t size;
        const uint32_t brick = find_leaf(tree, voxel, size);
        const bool empty = brick == SVO_NO_DATA;
        const uint64_t mask = empty ? 0 : tree.bricks[brick].mask[0] | uint64_t{tree.bricks[brick].mask[1]} << 32;
        const ivec3 brick_low = voxel & ~(size - 1), brick_last = brick_low + (size - 1);
        if (!empty) size = 1;
        // An empty box is left in one step, a brick voxel by voxel.
        for (int32_t steps = 0; steps < 3 * BRICK_SIDE; ++steps) {
            if (mask >> bit_in_brick(voxel) & 1) {
                hit = {t, voxel, brick};
                return true;
            }
            const ivec3 low = voxel & ~(size - 1), last = low + (size - 1);
            int axis = 0;
            float t_leave = kInfinity;
            for (int i = 0; i < 3; ++i) {
                const float at = (static_cast<float>(forward[i] ? last[i] + 1 : low[i]) - origin[i]) * inverse[i];
                if (at < t_leave) axis = i, t_leave = at;
            }
            t = std::max(t, t_leave);
            if (!(t < t_end)) return false;
            if (size > 1) {
                const ivec3 now = voxel_at(origin + t * direction, low, last);
                for (int i = 0; i < 3; ++i)
                    voxel[i] = forward[i] ? std::max(voxel[i], now[i]) : std::min(voxel[i], now[i]);
            }
            voxel[axis] = forward[axis] ? last[axis] + 1 : low[axis] - 1;
            if (voxel[axis] < 0 || voxel[axis] >= resolution) return false;
            if (voxel[axis] < brick_low[axis] || voxel[axis] > brick_last[axis]) break;
        }
    }
    return false;
}

vec3 to_voxels(const SvoView& tree, const vec3& p) {
    return (p - tree.constants.grid.low) * tree.constants.voxels_per_m;
}

bool occluded_between(const SvoView& tree, const vec3& a, const vec3& b, float pull_in) {
    const float length = glm::length(b - a);
    if (!(length > 2 * pull_in)) return false;
    SetVoxel hit;
    return march(tree, a, (b - a) / length, pull_in, length - pull_in, hit);
}

uint32_t surface_of(const SvoView& tree, uint32_t brick, const ivec3& voxel) {
    const uint64_t mask = tree.bricks[brick].mask[0] | uint64_t{tree.bricks[brick].mask[1]} << 32;
    const auto before = static_cast<uint32_t>(std::popcount(mask & ((1ull << bit_in_brick(voxel)) - 1)));
    return tree.surfaces[size_t{tree.constants.surface_base} + tree.surfaces[brick] + before];
}

}  // namespace

bool SvoView::is_set(const uvec3& voxel) const {
    int32_t size;
    const uint32_t brick = find_leaf(*this, ivec3(voxel), size);
    return brick != SVO_NO_DATA && has_bit(bricks[brick], ivec3(voxel));
}

uint32_t SvoView::surface_at(const vec3& position) const {
    const vec3 at = to_voxels(*this, position), end(static_cast<float>(constants.grid.resolution));
    if (!(glm::all(glm::greaterThanEqual(at, vec3(0))) && glm::all(glm::lessThan(at, end)))) return ~0u;
    const ivec3 voxel(at);
    int32_t size;
    const uint32_t brick = find_leaf(*this, voxel, size);
    return brick != SVO_NO_DATA && has_bit(bricks[brick], voxel) ? surface_of(*this, brick, voxel) : ~0u;
}

vec3 svo_lift(const SvoView& tree, const vec3& position, const vec3& normal, float offset) {
    const vec3 n = glm::abs(normal);
    return position + offset * tree.constants.grid.cell_m * (n.x + n.y + n.z) * normal;
}

bool svo_occluded(const SvoView& tree, const vec3& a, const vec3& b) {
    return occluded_between(tree, to_voxels(tree, a), to_voxels(tree, b), SVO_BLIND_PULL_IN);
}

bool svo_occluded(const SvoView& tree, const vec3& a, const vec3& normal_a, const vec3& b, const vec3& normal_b,
                  const SvoOffsets& offsets) {
    const vec3 from = to_voxels(tree, svo_lift(tree, a, normal_a, offsets.normal)),
               to = to_voxels(tree, svo_lift(tree, b, normal_b, offsets.normal));
    if (!(glm::dot(to - from, b - a) > 0)) return false;  // nearer to each other than they were lifted
    return occluded_between(tree, from, to, offsets.pull_in);
}

bool svo_first_voxel(const SvoView& tree, const Ray& ray, VoxelHit& hit) {
    SetVoxel set;
    if (!(ray.t_max > 0) ||
        !march(tree, to_voxels(tree, ray.origin), ray.direction, 0, ray.t_max * tree.constants.voxels_per_m, set))
        return false;
    hit = {set.t * tree.constants.grid.cell_m, uvec3(set.voxel), ~0u};
    if (!tree.surfaces.empty()) hit.surface = surface_of(tree, set.brick, set.voxel);
    return true;
}

}  // namespace photond
