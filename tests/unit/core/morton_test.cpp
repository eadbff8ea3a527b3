// Morton codes against their bits one by one.

#include "renderer/core/morton.h"

#include <gtest/gtest.h>

#include "renderer/core/rng.h"

namespace photond::morton_test {
namespace {

/// Bit i of x, y and z at bits 3 i, 3 i + 1 and 3 i + 2.
uint64_t bit_by_bit(const uvec3& cell, uint32_t bits) {
    uint64_t code = 0;
    for (uint32_t i = 0; i < bits; ++i)
        for (int axis = 0; axis < 3; ++axis)
            code |= uint64_t{cell[axis] >> i & 1} << (3 * i + static_cast<uint32_t>(axis));
    return code;
}

TEST(Morton, BitsTakeTurns) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 2000; ++i) {
        const auto number = [&](float below) { return static_cast<uint32_t>(random.next() * below); };
        const uvec3 small(number(1024), number(1024), number(1024)), wide(number(65536), number(65536), number(65536));
        EXPECT_EQ(morton_code(small), bit_by_bit(small, 10));
        EXPECT_EQ(morton_code_wide(small), bit_by_bit(small, 10));
        EXPECT_EQ(morton_code_wide(wide), bit_by_bit(wide, 16));
    }
    EXPECT_EQ(morton_code(uvec3(1023)), (1u << 30) - 1);
    EXPECT_EQ(morton_code_wide(uvec3(65535)), (uint64_t{1} << 48) - 1);
}

TEST(Morton, PointsOutsideCountAsOnTheBorder) {
    const Bounds3 bounds{vec3(-1, 0, 2), vec3(1, 4, 3)};
    EXPECT_EQ(morton_code(bounds, bounds.min), 0u);
    EXPECT_EQ(morton_code(bounds, bounds.max), (1u << 30) - 1);
    EXPECT_EQ(morton_code(bounds, bounds.min - 5.0f), 0u);
    EXPECT_EQ(morton_code(bounds, bounds.max + 5.0f), (1u << 30) - 1);
    EXPECT_EQ(morton_code(bounds, bounds.centre()), bit_by_bit(uvec3(511), 10));
    // A box without thickness.
    EXPECT_EQ(morton_code({vec3(0), vec3(1, 0, 1)}, vec3(1, 0, 0)), bit_by_bit(uvec3(1023, 0, 0), 10));
}

}  // namespace
}  // namespace photond::morton_test
