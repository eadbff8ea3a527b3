#include "renderer/voxels/svo_march.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "renderer/core/lanes.h"

namespace photond {

namespace {

using glm::ivec3;
namespace stdx = std::experimental;

constexpr int kBrickShift = 2;  // log2(BRICK_SIDE)

/// A brick's bit of a voxel.
uint32_t bit_in_brick(const ivec3& voxel) {
    return static_cast<uint32_t>((voxel.x & 3) | (voxel.y & 3) << 2 | (voxel.z & 3) << 4);
}

bool has_bit(const gpu::SvoBrick& brick, const ivec3& voxel) {
    const uint32_t bit = bit_in_brick(voxel);
    return brick.mask[bit / 32] >> bit % 32 & 1;
}

/// The leaf that holds a voxel: a brick's place, or SVO_NO_DATA for an empty box; of 2^shift voxels along an edge.
/// Begins with a tile whose nodes are of 2^(shift - 1) voxels.
uint32_t find_leaf(const SvoView& tree, uint32_t tile, const ivec3& voxel, int& shift) {
    for (;;) {
        --shift;
        const auto child =
            static_cast<uint32_t>((voxel.x >> shift & 1) | (voxel.y >> shift & 1) << 1 | (voxel.z >> shift & 1) << 2);
        const gpu::SvoNode& node = tree.nodes[size_t{tile} * 8 + child];
        if (!(node.info & SVO_FLAGGED) || shift == kBrickShift) return node.data;
        tile = node.info & SVO_TILE_MASK;
    }
}

struct SetVoxel {
    float t;
    ivec3 voxel;
    uint32_t brick;
};

/// Box masks of a brick: bits of the voxels whose coordinate along an axis is from i to j, at 4 i + j; as good as the
/// other way round.
constexpr std::array<std::array<uint64_t, 16>, 3> make_slabs() {
    std::array<std::array<uint64_t, 16>, 3> slabs{};
    for (uint32_t bit = 0; bit < 64; ++bit)
        for (uint32_t axis = 0; axis < 3; ++axis)
            for (uint32_t i = 0; i < 4; ++i)
                for (uint32_t j = 0; j < 4; ++j) {
                    const uint32_t at = bit >> 2 * axis & 3;
                    if (at >= std::min(i, j) && at <= std::max(i, j)) slabs[axis][4 * i + j] |= 1ull << bit;
                }
    return slabs;
}
constexpr std::array<std::array<uint64_t, 16>, 3> kSlabs = make_slabs();

/// One number each, or as many as the machine treats at once.
using One = stdx::simd<float, stdx::simd_abi::scalar>;
template <class Float>
using IntOf = stdx::rebind_simd_t<int32_t, Float>;
template <class Float>
using Vec = std::array<Float, 3>;
template <class Float>
constexpr size_t kCount = Float::size();

/// Rays in voxels, seen in mirrors that make them go up along all axes: the voxel v of an axis is there v or resolution
/// - 1 - v, the plane p is p or resolution - p.
template <class Float>
struct Ways {
    Vec<Float> origin, direction, inverse;
    Vec<Float> sign, plane_base, voxel_base;  // plane = plane_base + sign * mirrored plane; voxels likewise
    IntOf<Float> octant;                      // bit i: down along axis i
    Float t, t_end;
};

template <class Float>
Float select(const typename Float::mask_type& mask, const Float& a, Float b) {
    where(mask, b) = a;
    return b;
}

/// Rays for t in [t_begin, t_end). Those that are no numbers, have no direction or meet nothing of the grid end before
/// they begin.
template <class Float>
Ways<Float> make_ways(float resolution, const Vec<Float>& origin, const Vec<Float>& direction, const Float& t_begin,
                      const Float& t_end) {
    constexpr float kLeast = 1e-20f;
    Ways<Float> ways{.origin = origin, .direction = direction, .octant = 0, .t = t_begin, .t_end = t_end};
    typename Float::mask_type finite(true), leads(false);
    Float octant = 0.0f;
    for (size_t i = 0; i < 3; ++i) {
        const Float& o = origin[i];
        const Float& d = direction[i];
        finite = finite && o - o == 0.0f && d - d == 0.0f;
        const auto tiny = stdx::abs(d) < kLeast;
        leads = leads || !tiny;
        const Float& inverse = ways.inverse[i] = 1.0f / select(tiny, stdx::copysign(Float(kLeast), d), d);
        const auto down = !(inverse > 0.0f);
        octant += select(down, Float(static_cast<float>(1 << i)), Float(0.0f));
        ways.sign[i] = select(down, Float(-1.0f), Float(1.0f));
        ways.plane_base[i] = select(down, Float(resolution), Float(0.0f));
        ways.voxel_base[i] = select(down, Float(resolution - 1), Float(0.0f));
        const Float to_low = -o * inverse, to_high = (resolution - o) * inverse;
        ways.t = stdx::max(ways.t, stdx::min(to_low, to_high));
        ways.t_end = stdx::min(ways.t_end, stdx::max(to_low, to_high));
    }
    ways.octant = stdx::static_simd_cast<IntOf<Float>>(octant);
    where(!finite || !leads, ways.t_end) = -kInfinity;
    return ways;
}

enum class Walk { Hit, Left, End };

/// One of the rays voxel by voxel through a brick, from its voxel in it; that and t go on.
template <class Float>
Walk walk_brick(const Ways<Float>& ways, size_t lane, uint64_t mask, uint32_t flips, ivec3& voxel, float& t) {
    float at[3][4];  // where the brick's voxels are left
    const ivec3 low = voxel & ~(BRICK_SIDE - 1);
    for (size_t i = 0; i < 3; ++i) {
        const float base = ways.plane_base[i][lane], sign = ways.sign[i][lane];
        const float origin = ways.origin[i][lane], inverse = ways.inverse[i][lane];
        for (int k = 0; k < BRICK_SIDE; ++k)
            at[i][k] = (base + sign * static_cast<float>(low[static_cast<int>(i)] + k + 1) - origin) * inverse;
    }
    const float t_end = ways.t_end[lane];
    int x = voxel.x & 3, y = voxel.y & 3, z = voxel.z & 3;
    while (!(mask >> (static_cast<uint32_t>(x | y << 2 | z << 4) ^ flips) & 1)) {
        const float tx = at[0][x], ty = at[1][y], tz = at[2][z];
        t = std::max(t, std::min({tx, ty, tz}));
        if (!(t < t_end)) return Walk::End;
        const bool to_x = tx <= ty && tx <= tz, to_y = !to_x && ty <= tz;
        x += to_x, y += to_y, z += !to_x && !to_y;
        if ((x | y | z) & BRICK_SIDE) {
            voxel = low + ivec3(x, y, z);
            return Walk::Left;
        }
    }
    voxel = low + ivec3(x, y, z);
    return Walk::Hit;
}

/// The first set voxel that each ray lies in. A ray that meets none has a brick of SVO_NO_DATA.
template <class Float>
void march(const SvoView& tree, Ways<Float>& ways, std::array<SetVoxel, kCount<Float>>& hits) {
    using Int = IntOf<Float>;
    using Numbers = std::array<int32_t, kCount<Float>>;
    const auto ints = [](const Float& x) { return stdx::static_simd_cast<Int>(x); };
    const auto floats = [](const Int& x) { return stdx::static_simd_cast<Float>(x); };
    const auto store = [](const Int& x) {
        Numbers numbers;
        x.copy_to(numbers.data(), stdx::element_aligned);
        return numbers;
    };
    const SvoCells& cells = *tree.cells;
    const auto resolution = static_cast<int32_t>(tree.constants.grid.resolution);
    const int bits = static_cast<int>(cells.bits), shift = static_cast<int>(cells.shift);

    auto active = ways.t < ways.t_end;
    Vec<Int> voxel;
    Int flip = 0, flip_bits = 0;
    for (size_t i = 0; i < 3; ++i) {
        const auto axis = static_cast<int>(i);
        const Float at = stdx::floor(ways.origin[i] + ways.t * ways.direction[i]);
        const Float inside = stdx::min(stdx::max(at, Float(0.0f)), Float(static_cast<float>(resolution - 1)));
        voxel[i] = ints(select(active, ways.voxel_base[i] + ways.sign[i] * inside, Float(0.0f)));
        const Int down = -(ways.octant >> axis & 1);
        flip |= (down & ((1 << bits) - 1)) << (bits * axis);
        flip_bits |= (down & (BRICK_SIDE - 1)) << (2 * axis);
    }
    const Int plane = ways.octant << (3 * bits);
    const auto nowhere = static_cast<int32_t>(cells.free.size() - 1);
    const Numbers flips = store(flip_bits), octants = store(ways.octant);
    for (SetVoxel& hit : hits) hit.brick = SVO_NO_DATA;

    while (stdx::any_of(active)) {
        const Int cell = (voxel[0] >> shift | (voxel[1] >> shift) << bits | (voxel[2] >> shift) << 2 * bits) ^ flip;
        const Int idle = ints(select(active, Float(0.0f), Float(-1.0f)));
        const Numbers cell_at = store(cell), free_at = store(((cell | plane) & ~idle) | (idle & nowhere));
        // Boxes to leave: of `box` times 2^shift voxels along an edge. Bit i of `near`: lane i's may hold voxels.
        std::array<uint32_t, kCount<Float>> bricks{};
        Numbers boxes, shifts;
        uint32_t near = 0;
        for (size_t lane = 0; lane < kCount<Float>; ++lane) {
            boxes[lane] = cells.free[static_cast<size_t>(free_at[lane])];
            shifts[lane] = shift;
            near |= uint32_t{boxes[lane] == 0} << lane;
        }
        Int box(boxes.data(), stdx::element_aligned), box_shift = shift;
        box = stdx::max(box, Int(1));
        if (shift != kBrickShift && near != 0) {
            for (uint32_t left = near; left != 0; left &= left - 1) {
                const auto lane = static_cast<size_t>(std::countr_zero(left));
                ivec3 at;
                for (int i = 0; i < 3; ++i)
                    at[i] = voxel[static_cast<size_t>(i)][lane] ^ (octants[lane] >> i & 1 ? resolution - 1 : 0);
                const uint32_t tile = cells.starts[static_cast<size_t>(cell_at[lane])];
                bricks[lane] = find_leaf(tree, tile, at, shifts[lane]);
                if (bricks[lane] == SVO_NO_DATA) near &= ~(1u << lane);
            }
            box_shift.copy_from(shifts.data(), stdx::element_aligned);
        }
        Vec<Float> leave;
        Vec<Int> end;
        for (size_t i = 0; i < 3; ++i) {
            end[i] = ((voxel[i] >> box_shift) + box) << box_shift;
            leave[i] = (ways.plane_base[i] + ways.sign[i] * floats(end[i]) - ways.origin[i]) * ways.inverse[i];
        }
        const auto to_x = leave[0] <= leave[1] && leave[0] <= leave[2], to_y = !to_x && leave[1] <= leave[2];
        const std::array<typename Float::mask_type, 3> to = {to_x, to_y, !to_x && !to_y};
        Float t = stdx::max(ways.t, stdx::min(leave[0], stdx::min(leave[1], leave[2])));
        Vec<Int> last;    // voxels before the boxes are left,
        Vec<Float> next;  // and those after
        for (size_t i = 0; i < 3; ++i) {
            const Float at = ways.voxel_base[i] + ways.sign[i] * stdx::floor(ways.origin[i] + t * ways.direction[i]);
            const Float inside = stdx::min(stdx::max(at, floats(voxel[i])), floats(end[i] - 1));
            last[i] = ints(select(active, inside, Float(0.0f)));
            next[i] = select(to[i], floats(end[i]), inside);
        }

        // Boxes that hold voxels: bricks.
        std::array<Numbers, 3> slabs;
        for (size_t i = 0; i < 3; ++i) {
            const Int turned = -(ways.octant >> static_cast<int>(i) & 1) & 15;
            slabs[i] = store(((voxel[i] & 3) << 2 | (last[i] & 3)) ^ turned);
        }
        for (; near != 0; near &= near - 1) {
            const auto lane = static_cast<size_t>(std::countr_zero(near));
            if (shift == kBrickShift) bricks[lane] = cells.starts[static_cast<size_t>(cell_at[lane])];
            const gpu::SvoBrick& brick = tree.bricks[bricks[lane]];
            const uint64_t mask = brick.mask[0] | uint64_t{brick.mask[1]} << 32;
            uint64_t met = mask;
            for (size_t i = 0; i < 3; ++i) met &= kSlabs[i][static_cast<size_t>(slabs[i][lane])];
            if (met == 0) continue;
            ivec3 at(static_cast<int>(voxel[0][lane]), static_cast<int>(voxel[1][lane]),
                     static_cast<int>(voxel[2][lane]));
            float t_there = ways.t[lane];
            const Walk walk = walk_brick(ways, lane, mask, static_cast<uint32_t>(flips[lane]), at, t_there);
            t[lane] = walk == Walk::Left ? t_there : kInfinity;
            for (int i = 0; i < 3; ++i) next[static_cast<size_t>(i)][lane] = static_cast<float>(at[i]);
            if (walk != Walk::Hit) continue;
            for (int i = 0; i < 3; ++i) at[i] ^= octants[lane] >> i & 1 ? resolution - 1 : 0;
            hits[lane] = {t_there, at, bricks[lane]};
        }
        ways.t = t;
        const Float farthest = stdx::max(next[0], stdx::max(next[1], next[2]));
        active = active && t < ways.t_end && farthest < static_cast<float>(resolution);
        for (size_t i = 0; i < 3; ++i) voxel[i] = ints(select(active, next[i], Float(0.0f)));
    }
}

vec3 to_voxels(const SvoView& tree, const vec3& p) {
    return (p - tree.constants.grid.low) * tree.constants.voxels_per_m;
}

template <class Float>
Vec<Float> to_voxels(const SvoView& tree, const Vec<Float>& p) {
    const vec3& low = tree.constants.grid.low;
    const float scale = tree.constants.voxels_per_m;
    return {(p[0] - low.x) * scale, (p[1] - low.y) * scale, (p[2] - low.z) * scale};
}

bool march(const SvoView& tree, const vec3& origin, const vec3& direction, float t_begin, float t_end, SetVoxel& hit) {
    auto way = make_ways<One>(static_cast<float>(tree.constants.grid.resolution), {origin.x, origin.y, origin.z},
                              {direction.x, direction.y, direction.z}, t_begin, t_end);
    std::array<SetVoxel, 1> hits;
    march(tree, way, hits);
    hit = hits[0];
    return hit.brick != SVO_NO_DATA;
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
    int shift = std::countr_zero(constants.grid.resolution);
    const uint32_t brick = find_leaf(*this, 0, ivec3(voxel), shift);
    return brick != SVO_NO_DATA && has_bit(bricks[brick], ivec3(voxel));
}

uint32_t SvoView::surface_at(const vec3& position) const {
    const vec3 at = to_voxels(*this, position), end(static_cast<float>(constants.grid.resolution));
    if (!(glm::all(glm::greaterThanEqual(at, vec3(0))) && glm::all(glm::lessThan(at, end)))) return ~0u;
    const ivec3 voxel(at);
    int shift = std::countr_zero(constants.grid.resolution);
    const uint32_t brick = find_leaf(*this, 0, voxel, shift);
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

void svo_occluded(const SvoView& tree, std::span<const SvoSegment> segments, std::span<uint8_t> occluded,
                  float reach_m) {
    using Float = FloatLanes;
    const Float reach = reach_m * tree.constants.voxels_per_m;
    for (size_t first = 0; first < segments.size(); first += kLanes) {
        const size_t count = std::min(segments.size() - first, kLanes);
        const auto load = [&](auto member) {
            Vec<Float> v;
            for (int i = 0; i < 3; ++i)
                v[static_cast<size_t>(i)] =
                    Float([&](size_t lane) { return (segments[first + std::min(lane, count - 1)].*member)[i]; });
            return v;
        };
        const Vec<Float> a = load(&SvoSegment::a), b = load(&SvoSegment::b);
        const auto lifted = [&](const Vec<Float>& p, const Vec<Float>& n) {
            const Float offset =
                SVO_NORMAL_OFFSET * tree.constants.grid.cell_m * (stdx::abs(n[0]) + stdx::abs(n[1]) + stdx::abs(n[2]));
            return to_voxels<Float>(tree, {p[0] + offset * n[0], p[1] + offset * n[1], p[2] + offset * n[2]});
        };
        const Vec<Float> from = lifted(a, load(&SvoSegment::normal_a)), to = lifted(b, load(&SvoSegment::normal_b));
        Vec<Float> along;
        for (size_t i = 0; i < 3; ++i) along[i] = to[i] - from[i];
        const Float length = stdx::sqrt(along[0] * along[0] + along[1] * along[1] + along[2] * along[2]);
        const Float ahead = along[0] * (b[0] - a[0]) + along[1] * (b[1] - a[1]) + along[2] * (b[2] - a[2]);
        const auto asked = ahead > 0.0f && length > 2 * SVO_PULL_IN;
        for (size_t i = 0; i < 3; ++i) along[i] /= length;
        const Float end = select(asked, stdx::min(length - SVO_PULL_IN, reach), Float(-kInfinity));
        Ways<Float> ways =
            make_ways<Float>(static_cast<float>(tree.constants.grid.resolution), from, along, SVO_PULL_IN, end);
        std::array<SetVoxel, kLanes> hits;
        march(tree, ways, hits);
        for (size_t lane = 0; lane < count; ++lane) occluded[first + lane] = hits[lane].brick != SVO_NO_DATA;
    }
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
