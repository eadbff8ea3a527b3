// The hash grid against a loop over all points: the same points found, bit by bit of their distances.

#include "renderer/photons/hash_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "renderer/core/rng.h"
#include "tests/support/threads.h"

namespace photond::hash_grid_test {
namespace {

using Found = std::pair<uint32_t, float>;  // index of the given points, squared distance

struct Built {
    explicit Built(const std::vector<vec3>& points, float radius_m)
        : order(points.size()), grid(points, radius_m, order) {}
    std::vector<uint32_t> order;
    HashGrid grid;
};

std::vector<Found> search(const Built& built, const vec3& p, float radius_m) {
    Neighbours out;
    out.found.resize(3);  // of an earlier search
    built.grid.find_within(p, radius_m, out);
    EXPECT_EQ(out.radius_m, radius_m);
    std::vector<Found> found;
    for (const Neighbours::Found& f : out.found) found.emplace_back(built.order[f.index], f.distance_sq_m2);
    std::sort(found.begin(), found.end());
    return found;
}

std::vector<Found> brute_force(const std::vector<vec3>& points, const vec3& p, float radius_m) {
    std::vector<Found> found;
    for (uint32_t i = 0; i < points.size(); ++i) {
        const float d_sq = HashGrid::distance_sq_m2(p, points[i]);
        if (d_sq < radius_m * radius_m) found.emplace_back(i, d_sq);
    }
    return found;
}

/// All that are near a box are found, in ascending order, and none that is a little farther.
void expect_near_box(const std::vector<vec3>& points, const Built& built, const Bounds3& box, float radius_m) {
    std::vector<uint32_t> found{7};  // of an earlier search
    built.grid.find_near_box(box, radius_m, found);
    ASSERT_EQ(found.front(), 7u);
    found.erase(found.begin());
    ASSERT_TRUE(std::is_sorted(found.begin(), found.end(), std::less_equal<>()) && "each once");
    std::vector<uint8_t> near(points.size());
    for (const uint32_t index : found) near[built.order[index]] = 1;
    for (size_t i = 0; i < points.size(); ++i) {
        const float distance_m = glm::length(points[i] - glm::clamp(points[i], box.min, box.max));
        ASSERT_TRUE(near[i] || distance_m > 0.9999f * radius_m);
        ASSERT_TRUE(!near[i] || distance_m < 1.0001f * radius_m);
    }
}

void expect_exact(const std::vector<vec3>& points, float grid_radius_m, const std::vector<vec3>& queries) {
    const Built built(points, grid_radius_m);
    ASSERT_EQ(built.grid.size(), points.size());
    std::vector<uint32_t> sorted = built.order;
    std::sort(sorted.begin(), sorted.end());
    for (uint32_t i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i], i) << "order is no permutation";
    for (uint32_t i = 0; i < points.size(); ++i) ASSERT_EQ(built.grid.position(i), points[built.order[i]]);
    EXPECT_LE(built.grid.bytes(), HashGrid::bytes_for(points.size()));
    for (size_t i = 0; i < queries.size(); i += 8) {
        const Bounds3 box{queries[i] - 0.2f * grid_radius_m, queries[i] + vec3(0.4f, 0, 0.1f) * grid_radius_m};
        for (const float share : {1.0f, 0.37f}) expect_near_box(points, built, box, share * grid_radius_m);
    }
    for (const vec3& p : queries)
        for (const float share : {1.0f, 0.37f})
            ASSERT_EQ(search(built, p, share * grid_radius_m), brute_force(points, p, share * grid_radius_m))
                << "radius " << share * grid_radius_m << " at " << p.x << ' ' << p.y << ' ' << p.z;
}

vec3 in_box(RandomStream& random, const vec3& size) {
    const float x = random.next(), y = random.next(), z = random.next();
    return size * (vec3(x, y, z) - 0.5f);
}

std::vector<vec3> box_points(size_t count, const vec3& size, const vec3& centre, uint64_t seed) {
    RandomStream random(seed, RandomDomain::Test, 0, 0);
    std::vector<vec3> points(count);
    for (vec3& p : points) p = centre + in_box(random, size);
    return points;
}

TEST(HashGrid, FindsWhatALoopFindsInAVolumeAndOnPlanes) {
    for (const vec3& size :
         {vec3(1, 1, 1), vec3(2, 0, 2), vec3(0, 3, 1), vec3(2, 2, 0), vec3(0, 0, 5), vec3(0, 0, 0)}) {
        const auto points = box_points(3000, size, vec3(0.3f, -2, 7), 1);
        auto queries = box_points(60, size * 1.3f + 0.1f, vec3(0.3f, -2, 7), 2);
        queries.insert(queries.end(), points.begin(), points.begin() + 20);
        for (const float radius : {0.01f, 0.1f, 0.5f, 20.0f}) expect_exact(points, radius, queries);
    }
}

TEST(HashGrid, TiesAtTheRadiusAreNotFound) {
    // Whole coordinates: all distances are exact, and many equal the radius.
    std::vector<vec3> points;
    for (int z = -5; z <= 5; ++z)
        for (int y = -5; y <= 5; ++y)
            for (int x = -5; x <= 5; ++x) points.emplace_back(x, y, z);
    for (const float radius : {1.0f, 2.0f, 3.0f, 5.0f}) expect_exact(points, radius, points);
    const Built unit(points, 1.0f);
    EXPECT_EQ(search(unit, vec3(0), 1.0f).size(), 1u) << "strictly nearer: the six at the radius do not count";
    EXPECT_EQ(search(unit, vec3(0), std::nextafter(1.0f, 0.0f)).size(), 1u);
    EXPECT_EQ(search(Built(points, 1.001f), vec3(0), 1.001f).size(), 7u);
}

TEST(HashGrid, ExtentOfAMillionRadii) {
    // Clusters far apart: the cells are hashed, and rows longer than the table wrap round.
    RandomStream random(3, RandomDomain::Test, 0, 0);
    std::vector<vec3> centres, points, queries;
    for (int i = 0; i < 30; ++i) centres.push_back(in_box(random, vec3(2e4f, 2e4f, 2e4f)));
    for (int i = 0; i < 30; ++i) centres.push_back(vec3(random.next() * 2e4f, 1, 1));
    for (const vec3& c : centres) {
        for (int i = 0; i < 40; ++i) points.push_back(c + in_box(random, vec3(0.08f)));
        for (int i = 0; i < 4; ++i) queries.push_back(c + in_box(random, vec3(0.1f)));
    }
    expect_exact(points, 0.02f, queries);
}

TEST(HashGrid, ARadiusLargerThanTheBox) {
    const auto points = box_points(500, vec3(1), vec3(0), 4);
    expect_exact(points, 3.0f, box_points(50, vec3(8), vec3(0), 5));
    const Built built(points, 1e6f);
    EXPECT_EQ(search(built, vec3(0), 1e6f).size(), points.size());
    EXPECT_EQ(search(built, vec3(1e7f, 0, 0), 1e6f).size(), 0u);
}

TEST(HashGrid, FarFromTheOriginAndExtremeCoordinates) {
    // Spacing of floats at 1e5 is 8 mm: many points coincide.
    expect_exact(box_points(3000, vec3(4), vec3(1e5f, -1e5f, 1e5f), 6), 0.1f,
                 box_points(60, vec3(5), vec3(1e5f, -1e5f, 1e5f), 7));
    for (const float scale : {1e-15f, 1e15f})
        expect_exact(box_points(2000, vec3(scale), vec3(0), 8), 0.1f * scale,
                     box_points(40, vec3(1.2f * scale), vec3(0), 9));
    const float huge = 3e38f;
    const std::vector<vec3> corners = {vec3(-huge), vec3(huge), vec3(0), vec3(0.5f), vec3(huge, -huge, 0)};
    expect_exact(corners, 1.0f, corners);
    expect_exact(box_points(100, vec3(1), vec3(0), 10), 1.0f, {vec3(huge), vec3(-huge, 0, 0)});
}

TEST(HashGrid, AHundredThousandPointsInACell) {
    auto points = box_points(100'000, vec3(1e-3f), vec3(0), 11);
    for (size_t i = 0; i < 1000; ++i) points[i] = vec3(0);  // coincident
    const auto around = box_points(1000, vec3(10), vec3(0), 12);
    points.insert(points.end(), around.begin(), around.end());
    expect_exact(points, 0.01f, {vec3(0), vec3(5e-3f, 0, 0), vec3(0.0102f, 0, 0), vec3(-1e-2f, 1e-3f, 0), vec3(3)});
}

TEST(HashGrid, FewPointsOrNone) {
    expect_exact({}, 1.0f, {vec3(0)});
    expect_exact({vec3(1, 2, 3)}, 0.5f, {vec3(1, 2, 3), vec3(1.2f, 2, 3), vec3(1.5f, 2, 3), vec3(9)});
    Neighbours out;
    out.found.resize(1);
    HashGrid().find_within(vec3(0), 0.0f, out);
    EXPECT_TRUE(out.found.empty());
}

TEST(HashGrid, TheSameForAnyNumberOfThreads) {
    auto points = box_points(150'000, vec3(3, 1, 2), vec3(0), 13);
    const auto build = [&](int threads) { return test::on_threads(threads, [&] { return Built(points, 0.02f); }); };
    const Built one = build(1), four = build(4);
    EXPECT_EQ(one.order, four.order);
    Neighbours a, b;
    for (const vec3& p : box_points(100, vec3(3, 1, 2), vec3(0), 14)) {
        one.grid.find_within(p, 0.02f, a);
        four.grid.find_within(p, 0.02f, b);
        ASSERT_EQ(a.found.size(), b.found.size());
        for (size_t i = 0; i < a.found.size(); ++i) ASSERT_EQ(a.found[i].index, b.found[i].index);
    }
}

}  // namespace
}  // namespace photond::hash_grid_test
