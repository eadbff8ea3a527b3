// Triangles against voxels: held against clipping each triangle by each box, which shares nothing with separating axes.

#include "renderer/voxels/triangle_voxels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "renderer/core/rng.h"

namespace photond::triangle_voxels_test {
namespace {

constexpr int kBricks = 8;  // 32 voxels along an edge
constexpr int kVoxels = kBricks * BRICK_SIDE;

/// What is left of a triangle within a box, in double precision: whether anything.
bool clip(const QuantisedTriangle& triangle, const glm::ivec3& voxel, double widen) {
    std::vector<dvec3> polygon;
    for (const glm::ivec3& p : triangle.p) polygon.emplace_back(p);
    for (int axis = 0; axis < 3 && !polygon.empty(); ++axis) {
        for (const int side : {-1, 1}) {
            const double border = side * (VOXEL_UNITS * (voxel[axis] + (side > 0 ? 1 : 0)) + side * widen);
            const auto beyond = [&](const dvec3& p) { return side * p[axis] - border; };
            std::vector<dvec3> kept;
            for (size_t i = 0; i < polygon.size(); ++i) {
                const dvec3 a = polygon[i], b = polygon[(i + 1) % polygon.size()];
                const double da = beyond(a), db = beyond(b);
                if (da <= 0) kept.push_back(a);
                if ((da < 0) != (db < 0) && da != db) kept.push_back(a + (b - a) * (da / (da - db)));
            }
            polygon = kept;
        }
    }
    return !polygon.empty();
}

/// All voxels that the columns of a triangle's bricks give.
std::vector<bool> touched(const QuantisedTriangle& triangle) {
    std::vector<bool> set(size_t{kVoxels} * kVoxels * kVoxels);
    const TriangleVoxels voxels(triangle, kBricks);
    for (uint32_t c = 0; c < voxels.columns(); ++c) {
        glm::ivec3 brick;
        const BrickRange range = voxels.column(c, brick);
        for (brick[voxels.axis()] = range.begin; brick[voxels.axis()] < range.end; ++brick[voxels.axis()]) {
            const uint64_t mask = voxels.brick_mask(brick);
            for (int bit = 0; bit < 64; ++bit) {
                if (!(mask >> bit & 1)) continue;
                const glm::ivec3 v = brick * BRICK_SIDE + glm::ivec3(bit & 3, bit >> 2 & 3, bit >> 4);
                set[static_cast<size_t>((v.z * kVoxels + v.y) * kVoxels + v.x)] = true;
            }
        }
    }
    return set;
}

/// Every voxel whose box meets the triangle clearly is touched, none that misses it clearly.
void expect_exact(const QuantisedTriangle& triangle) {
    const std::vector<bool> set = touched(triangle);
    constexpr double kRounding = 1e-4;  // of clipping, in sub-units
    size_t wrong = 0, met = 0;
    for (int i = 0; i < kVoxels * kVoxels * kVoxels; ++i) {
        const glm::ivec3 voxel(i % kVoxels, i / kVoxels % kVoxels, i / kVoxels / kVoxels);
        const bool is = set[static_cast<size_t>(i)];
        met += is;
        if (is ? !clip(triangle, voxel, 1 + kRounding) : clip(triangle, voxel, 1 - kRounding)) ++wrong;
    }
    const auto text = [&](int i) {
        const glm::ivec3& p = triangle.p[static_cast<size_t>(i)];
        return std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + ", ";
    };
    EXPECT_EQ(wrong, 0u) << text(0) << text(1) << text(2);
    EXPECT_GT(met, 0u);
}

glm::ivec3 random_point(RandomStream& random, int extent) {
    const auto one = [&] { return static_cast<int>(random.next_bits() % static_cast<uint32_t>(extent)); };
    const int x = one(), y = one();
    return {x, y, one()};
}

constexpr int kExtent = kVoxels * VOXEL_UNITS;

TEST(TriangleVoxels, AreThoseThatClippingFinds) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 60; ++i)
        expect_exact({{random_point(random, kExtent), random_point(random, kExtent), random_point(random, kExtent)}});
}

TEST(TriangleVoxels, OfSmallTriangles) {
    RandomStream random(2, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 60; ++i) {
        const glm::ivec3 at = random_point(random, kExtent - 700);
        expect_exact({{at, at + random_point(random, 700), at + random_point(random, 700)}});
    }
}

TEST(TriangleVoxels, OfPointsSegmentsAndSlivers) {
    RandomStream random(3, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 20; ++i) {
        const glm::ivec3 a = random_point(random, kExtent / 2), d = random_point(random, kExtent / 4);
        expect_exact({{a, a, a}});
        expect_exact({{a, a, a + d}});
        expect_exact({{a, a + d, a + 2 * d}});
        expect_exact({{a, a + 2 * d, a + d + glm::ivec3(0, 1, 0)}});  // as wide as a sub-unit
    }
}

TEST(TriangleVoxels, OnTheVoxelsOwnBordersAndAlongAxes) {
    const auto at = [](int x, int y, int z) { return glm::ivec3(x, y, z) * VOXEL_UNITS; };
    expect_exact({{at(4, 8, 8), at(20, 8, 8), at(20, 8, 24)}});
    expect_exact({{at(4, 4, 4), at(12, 12, 4), at(12, 12, 12)}});
    expect_exact({{at(4, 8, 8), at(28, 8, 8), at(16, 8, 8)}});
    expect_exact({{at(8, 8, 8), at(8, 8, 8), at(8, 8, 8)}});
    expect_exact({{at(0, 0, 0), at(32, 0, 0), at(0, 32, 32)}});
}

TEST(TriangleVoxels, AreCutOffAtTheGridsBorder) {
    const TriangleVoxels outside(
        {{glm::ivec3(-9000, -9000, -9000), glm::ivec3(-8000, -9000, -9000), glm::ivec3(-9000, -8000, -9000)}}, kBricks);
    EXPECT_EQ(outside.columns(), 0u);
    expect_exact({{glm::ivec3(-90000, 700, 700), glm::ivec3(200000, 900, 700), glm::ivec3(4000, 500000, 9000)}});
}

TEST(VoxelGrid, HoldsItsBoundsWithAVoxelToSpare) {
    RandomStream random(4, RandomDomain::Test, 0, 0);
    for (const uint32_t resolution : {16u, 128u, 1024u}) {
        for (int i = 0; i < 200; ++i) {
            Bounds3 bounds;
            const float scale = std::exp2(60 * random.next() - 30), offset = std::exp2(20 * random.next() - 10);
            for (int k = 0; k < 2; ++k)
                bounds.extend(scale * (vec3(random.next_2d(), random.next()) + offset * vec3(1, -0.5f, 0.01f)));
            const gpu::SvoConstants constants = svo_constants_of(make_voxel_grid(bounds, resolution));
            for (const vec3& p : {bounds.min, bounds.max}) {
                const glm::ivec3 units = quantise(constants, p);
                for (int axis = 0; axis < 3; ++axis) {
                    ASSERT_GE(units[axis], VOXEL_UNITS / 2);
                    ASSERT_LE(units[axis], static_cast<int>(resolution - 1) * VOXEL_UNITS + VOXEL_UNITS / 2);
                }
            }
        }
    }
}

TEST(VoxelGrid, RoundsToTheNearestSubUnit) {
    const gpu::SvoConstants constants = svo_constants_of(make_voxel_grid({vec3(-3, 1, 5), vec3(4, 2, 6)}, 1024));
    RandomStream random(5, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 10'000; ++i) {
        const vec3 p = vec3(-3, 1, 5) + vec3(7, 1, 1) * vec3(random.next_2d(), random.next());
        const dvec3 exact =
            (dvec3(p) - dvec3(constants.grid.low)) * (double{VOXEL_UNITS} / double{constants.grid.cell_m});
        const dvec3 off = glm::abs(exact - dvec3(quantise(constants, p)));
        ASSERT_LT(std::max({off.x, off.y, off.z}), 0.55);
    }
}

TEST(VoxelGrid, StandsForNothingAndForAPointToo) {
    for (const Bounds3& bounds : {Bounds3{}, Bounds3{vec3(5), vec3(5)}, Bounds3{vec3(1e5f), vec3(1e5f)}}) {
        const VoxelGrid grid = make_voxel_grid(bounds, 64);
        EXPECT_GT(grid.cell_m, 0);
        EXPECT_TRUE(std::isfinite(grid.cell_m));
    }
    for (const uint32_t resolution : {0u, 8u, 48u, 2048u}) EXPECT_ANY_THROW(make_voxel_grid({}, resolution));
}

}  // namespace
}  // namespace photond::triangle_voxels_test
