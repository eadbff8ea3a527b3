// Cells of the radiance cache: sides by distance and ray, places told apart.

#include "renderer/methods/radiance_cache/cell_grid.h"

#include <gtest/gtest.h>

#include <set>

#include "renderer/core/rng.h"

namespace photond::cell_grid_test {
namespace {

bool same(const CellKey& a, const CellKey& b) { return a.place == b.place && a.fingerprint == b.fingerprint; }

TEST(CellGrid, SidesAreAtMostAShareOfTheDistanceAndMoreThanHalfOfIt) {
    const CellGrid grid{.coarsest_m = 8, .of_distance = 0.1f};
    for (float distance_m = 0.01f; distance_m < 60; distance_m *= 1.07f) {
        const std::optional<uint32_t> level = grid.level(distance_m, kInfinity);
        ASSERT_TRUE(level);
        EXPECT_LE(grid.side_m(*level), 0.1f * distance_m * 1.0001f);
        EXPECT_GT(grid.side_m(*level), 0.05f * distance_m * 0.9999f);
    }
    EXPECT_EQ(grid.level(1e9f, kInfinity), 0u) << "no cell is coarser than the coarsest";
}

TEST(CellGrid, NoRayAsksACellThatIsWiderThanWhatItIsSpreadOver) {
    const CellGrid grid{.coarsest_m = 8, .of_distance = 0.1f};
    const uint32_t by_eye = *grid.level(10, kInfinity);
    uint32_t finest = by_eye;
    for (float spread_m = 2; spread_m > 1e-3f; spread_m *= 0.9f) {
        const std::optional<uint32_t> level = grid.level(10, spread_m);
        if (!level) {
            EXPECT_LT(spread_m, grid.side_m(by_eye + CellGrid::kFinerLevels)) << "a cell would have done";
            continue;
        }
        EXPECT_LE(grid.side_m(*level), spread_m);
        EXPECT_GE(*level, by_eye);
        finest = std::max(finest, *level);
    }
    EXPECT_EQ(finest, by_eye + CellGrid::kFinerLevels);
    EXPECT_FALSE(grid.level(10, 0));
}

// A diffuse reflector's ray straight ahead is spread over its own length, a narrow lobe's over less, a mirror's not.
TEST(CellGrid, SpreadOfARayFollowsItsDensity) {
    EXPECT_FLOAT_EQ(ray_spread_m(3, kInvPi), 3);
    EXPECT_LT(ray_spread_m(3, 20), 0.4f);
    EXPECT_EQ(ray_spread_m(3, kInfinity), 0);
}

TEST(CellGrid, TellsPlacesSidesDirectionsAndLevelsApart) {
    const CellGrid grid{.origin = vec3(0.3f, -7, 2), .coarsest_m = 8};
    const vec3 p(1.23f, 0.5f, -0.7f), up(0, 1, 0);
    const CellKey key = grid.key(p, up, 0, 6);  // 12.5 cm
    EXPECT_TRUE(same(key, grid.key(p + vec3(0.001f), up, 0, 6)));
    EXPECT_TRUE(same(key, grid.key(p, glm::normalize(vec3(0.05f, 1, -0.1f)), 0, 6)));
    for (const CellKey& other :
         {grid.key(p, -up, 0, 6), grid.key(p, up, 1, 6), grid.key(p, up, 0, 7), grid.key(p, vec3(1, 0, 0), 0, 6),
          grid.key(p + vec3(0.125f, 0, 0), up, 0, 6), grid.key(p - vec3(0, 0.125f, 0), up, 0, 6),
          grid.key(p + vec3(0, 0, 0.125f), up, 0, 6)})
        EXPECT_FALSE(same(key, other));
}

// 2^20 cells: of pairs in a bucket of 2^17 some 2^-9 are expected to be alike.
TEST(CellGrid, FingerprintsAreNeverNothingAndHardlyEverAlike) {
    const CellGrid grid{.coarsest_m = 64};
    std::set<std::pair<uint32_t, uint32_t>> seen;
    constexpr uint32_t kBuckets = 1 << 17;
    size_t cells = 0;
    for (int x = 0; x < 64; ++x)
        for (int y = 0; y < 64; ++y)
            for (int z = 0; z < 64; ++z)
                for (const uint32_t level : {6u, 7u}) {
                    const CellKey key = grid.key(grid.side_m(level) * (vec3(x, y, z) + 0.5f), vec3(0, 0, 1), 0, level);
                    EXPECT_NE(key.fingerprint, 0u);
                    seen.emplace(key.place % kBuckets, key.fingerprint);
                    ++cells;
                }
    EXPECT_EQ(seen.size(), cells);
}

TEST(CellGrid, DirectionBinsDivideTheSphere) {
    RandomStream numbers(1, RandomDomain::Test, 0, 0);
    for (const uint32_t side : {1u, 3u, 8u}) {
        std::vector<uint32_t> found(side * side);
        for (int i = 0; i < 20'000; ++i) {
            const vec3 direction = glm::normalize(vec3(numbers.next(), numbers.next(), numbers.next()) - 0.4999f);
            const uint32_t bin = direction_bin(direction, side);
            ASSERT_LT(bin, side * side);
            ++found[bin];
        }
        for (const uint32_t count : found) EXPECT_GT(count, 0u);
    }
    for (const vec3& axis : {vec3(1, 0, 0), vec3(0, -1, 0), vec3(0, 0, 1), vec3(0, 0, -1)})
        EXPECT_LT(direction_bin(axis, 4), 16u);
}

}  // namespace
}  // namespace photond::cell_grid_test
