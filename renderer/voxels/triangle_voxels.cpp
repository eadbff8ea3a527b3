#include "renderer/voxels/triangle_voxels.h"

#include <bit>

namespace photond {

namespace {

constexpr int32_t kVoxel = VOXEL_UNITS, kBrick = BRICK_SIDE * VOXEL_UNITS;

/// Coordinates of the first and the last box of that size whose widened extent touches [low, high].
int32_t first_box(int32_t low, uint32_t size) { return (low - VOXEL_WIDEN - 1) >> std::countr_zero(size); }
int32_t last_box(int32_t high, uint32_t size) { return (high + VOXEL_WIDEN) >> std::countr_zero(size); }

int64_t floor_div(int64_t a, int64_t b) {  // b > 0
    const int64_t quotient = a / b;
    return quotient - (quotient * b > a ? 1 : 0);
}

/// An edge's normal in a plane, and where the triangle lies along it.
struct EdgeSpan {
    int64_t nu, nv, low, high;

    EdgeSpan(const glm::ivec2& a, const glm::ivec2& b, const glm::ivec2& c)
        : nu(int64_t{a.y} - b.y), nv(int64_t{b.x} - a.x) {
        const int64_t edge = nu * a.x + nv * a.y, corner = nu * c.x + nv * c.y;
        low = std::min(edge, corner), high = std::max(edge, corner);
    }
    /// Widens what lies along the normal so that it can be held against the least corner of a square.
    void hold_against_corners(int64_t side) {
        low -= side * (std::max<int64_t>(nu, 0) + std::max<int64_t>(nv, 0));
        high -= side * (std::min<int64_t>(nu, 0) + std::min<int64_t>(nv, 0));
    }
};

}  // namespace

TriangleVoxels::TriangleVoxels(const QuantisedTriangle& triangle, int32_t bricks) : p_(triangle.p) {
    low_ = glm::min(glm::min(p_[0], p_[1]), p_[2]);
    high_ = glm::max(glm::max(p_[0], p_[1]), p_[2]);
    for (int i = 0; i < 3; ++i) {
        const int u = (i + 1) % 3, v = (i + 2) % 3;
        const int64_t au = p_[1][u] - p_[0][u], av = p_[1][v] - p_[0][v], bu = p_[2][u] - p_[0][u],
                      bv = p_[2][v] - p_[0][v];
        normal_[static_cast<size_t>(i)] = au * bv - av * bu;
        offset_ += normal_[static_cast<size_t>(i)] * p_[0][i];
        first_brick_[i] = std::max(first_box(low_[i], kBrick), 0);
        end_brick_[i] = std::min(last_box(high_[i], kBrick) + 1, bricks);
    }
    // Without a normal: the axis it is shortest along.
    const bool flat = normal_[0] != 0 || normal_[1] != 0 || normal_[2] != 0;
    const auto weight = [&](int i) {
        return flat ? std::abs(normal_[static_cast<size_t>(i)]) : -int64_t{high_[i] - low_[i]};
    };
    for (int i = 1; i < 3; ++i)
        if (weight(i) > weight(axis_)) axis_ = i;
}

bool TriangleVoxels::square_may_touch(int u, int v, const glm::ivec2& low, int32_t side) const {
    const auto shadow = [&](size_t i) { return glm::ivec2(p_[i % 3][u], p_[i % 3][v]); };
    for (size_t i = 0; i < 3; ++i) {
        EdgeSpan edge(shadow(i), shadow(i + 1), shadow(i + 2));
        edge.hold_against_corners(side);
        const int64_t corner = edge.nu * low.x + edge.nv * low.y;
        if (corner < edge.low || corner > edge.high) return false;
    }
    return true;
}

BrickRange TriangleVoxels::column(uint32_t index, glm::ivec3& brick) const {
    const int u = (axis_ + 1) % 3, v = (axis_ + 2) % 3;
    const auto row = static_cast<uint32_t>(along(1));
    brick[axis_] = 0;
    brick[u] = first_brick_[u] + static_cast<int32_t>(index % row);
    brick[v] = first_brick_[v] + static_cast<int32_t>(index / row);
    constexpr int32_t kSide = kBrick + 2 * VOXEL_WIDEN;
    const glm::ivec2 low(brick[u] * kBrick - VOXEL_WIDEN, brick[v] * kBrick - VOXEL_WIDEN);
    if (!square_may_touch(u, v, low, kSide)) return {};

    BrickRange range{first_brick_[axis_], end_brick_[axis_]};
    const auto n = [&](int axis) { return normal_[static_cast<size_t>(axis)]; };
    if (n(axis_) != 0) {
        // Where the plane passes through the column.
        const int64_t sign = n(axis_) < 0 ? -1 : 1, nw = sign * n(axis_), nu = sign * n(u), nv = sign * n(v);
        const int64_t rest = sign * offset_ - nu * low.x - nv * low.y;
        const int64_t least = rest - kSide * (std::max<int64_t>(nu, 0) + std::max<int64_t>(nv, 0));
        const int64_t most = rest - kSide * (std::min<int64_t>(nu, 0) + std::min<int64_t>(nv, 0));
        const auto clamped = [](int64_t w) {
            return static_cast<int32_t>(std::clamp<int64_t>(w, -(1 << 24), 1 << 24));
        };
        range.begin = std::max(range.begin, first_box(clamped(floor_div(least, nw)), kBrick));
        range.end = std::min(range.end, last_box(clamped(floor_div(most, nw) + 1), kBrick) + 1);
    }
    return range;
}

uint32_t TriangleVoxels::square_mask(int u, int v, const glm::ivec3& brick) const {
    const auto shadow = [&](size_t i) { return glm::ivec2(p_[i % 3][u], p_[i % 3][v]); };
    const glm::ivec2 corner(brick[u] * kBrick - VOXEL_WIDEN, brick[v] * kBrick - VOXEL_WIDEN);
    uint32_t mask = 0xffff;
    for (size_t k = 0; k < 3; ++k) {
        EdgeSpan edge(shadow(k), shadow(k + 1), shadow(k + 2));
        edge.hold_against_corners(kVoxel + 2 * VOXEL_WIDEN);
        const int64_t first = edge.nu * corner.x + edge.nv * corner.y;
        uint32_t within = 0;
        for (int bit = 0; bit < 16; ++bit) {
            const int64_t at = first + kVoxel * (edge.nu * (bit & 3) + edge.nv * (bit >> 2));
            within |= static_cast<uint32_t>(at >= edge.low && at <= edge.high) << bit;
        }
        mask &= within;
    }
    return mask;
}

uint64_t TriangleVoxels::brick_mask(const glm::ivec3& brick) const {
    // Voxels of the brick that the triangle's box touches, along each axis.
    uint32_t row[3];
    for (int i = 0; i < 3; ++i) {
        const int32_t first = std::max(first_box(low_[i], kVoxel) - BRICK_SIDE * brick[i], 0);
        const int32_t last = std::min(last_box(high_[i], kVoxel) - BRICK_SIDE * brick[i], BRICK_SIDE - 1);
        if (first > last) return 0;
        row[i] = (2u << last) - (1u << first);
    }
    const uint32_t xy = square_mask(0, 1, brick), yz = square_mask(1, 2, brick), xz = square_mask(0, 2, brick);
    uint64_t mask = 0;
    for (int z = 0; z < BRICK_SIDE; ++z) {
        if (!(row[2] >> z & 1)) continue;
        for (int y = 0; y < BRICK_SIDE; ++y) {
            if (!(row[1] >> y & yz >> (y + 4 * z) & 1)) continue;
            const uint64_t voxels = row[0] & (xy >> 4 * y) & (xz >> 4 * z) & 0xf;
            mask |= voxels << (4 * y + 16 * z);
        }
    }
    if (normal_[0] == 0 && normal_[1] == 0 && normal_[2] == 0) return mask;

    constexpr int64_t kSide = kVoxel + 2 * VOXEL_WIDEN;
    int64_t low = offset_, high = offset_, first = 0;
    for (int i = 0; i < 3; ++i) {
        const int64_t n = normal_[static_cast<size_t>(i)];
        (n > 0 ? low : high) -= kSide * n;
        first += n * (int64_t{brick[i]} * kBrick - VOXEL_WIDEN);
    }
    for (uint64_t left = mask; left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left);
        const int64_t at =
            first + kVoxel * (normal_[0] * (bit & 3) + normal_[1] * (bit >> 2 & 3) + normal_[2] * (bit >> 4));
        if (at < low || at > high) mask &= ~(1ull << bit);
    }
    return mask;
}

}  // namespace photond
