// The kd-tree's answers are those of a loop over all points, for clouds that trees find easy and hard.

#include "renderer/photons/kd_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <string>

#include "renderer/core/rng.h"
#include "tests/support/threads.h"

namespace photond::kd_tree_test {
namespace {

constexpr uint32_t kSeed = 42;
constexpr uint32_t kBucket = KdTree::kBucket;

struct Cloud {
    std::string name;
    std::vector<vec3> points;
};

std::vector<vec3> make_points(size_t count, uint32_t stream, const std::function<vec3(RandomStream&)>& point) {
    RandomStream random(kSeed, RandomDomain::Test, 0, stream);
    std::vector<vec3> points(count);
    for (vec3& p : points) p = point(random);
    return points;
}

vec3 in_cube(RandomStream& random) {
    const float x = random.next(), y = random.next();
    return {x, y, random.next()};
}

std::vector<Cloud> clouds(size_t count) {
    std::vector<Cloud> all;
    const auto add = [&](const char* name, const std::function<vec3(RandomStream&)>& point) {
        all.push_back({name, make_points(count, static_cast<uint32_t>(all.size()), point)});
    };
    add("cube", in_cube);
    add("plane", [](RandomStream& random) { return vec3(random.next(), 0.25f, random.next()); });
    add("line", [](RandomStream& random) { return vec3(0.5f, 0.25f, random.next()); });
    add("slanted line", [](RandomStream& random) { return random.next() * vec3(1, 2, 3); });
    add("clusters", [](RandomStream& random) {
        const auto cluster = static_cast<float>(random.next_bits() % 7);
        return vec3(cluster, sqr(cluster), 3) + 1e-3f * in_cube(random);
    });
    add("lattice", [](RandomStream& random) { return glm::floor(6.0f * in_cube(random)); });  // many ties, many equal
    add("one place", [](RandomStream&) { return vec3(1, 2, 3); });
    add("two places", [](RandomStream& random) { return vec3(random.next_bits() % 2 ? 1.0f : -1.0f, 0, 0); });
    add("scales", [](RandomStream& random) {
        const float scale = std::exp(20 * (random.next() - 0.5f));
        return scale * (in_cube(random) - 0.5f);
    });
    add("tiny", [](RandomStream& random) { return 1e-4f * in_cube(random); });
    add("huge", [](RandomStream& random) { return 1e6f * in_cube(random); });
    add("far away", [](RandomStream& random) { return vec3(1e6f, -1e6f, 0) + in_cube(random); });  // 1/16 m apart
    return all;
}

/// A tree and the points in its order.
struct Built {
    std::vector<uint32_t> order;
    KdTree tree;
    std::vector<vec3> points;

    explicit Built(std::span<const vec3> given) : order(given.size()), tree(given, order) {
        for (const uint32_t i : order) points.push_back(given[i]);
    }
    float distance_sq(const vec3& p, uint32_t i) const {
        return length_sq(points[i].x - p.x, points[i].y - p.y, points[i].z - p.z);
    }
};

/// Points of the cloud, points near them, points about the cloud, and far from it.
std::vector<vec3> queries_for(std::span<const vec3> points, size_t count) {
    Bounds3 bounds;
    for (const vec3& p : points) bounds.extend(p);
    RandomStream random(kSeed, RandomDomain::Test, 1, points.size());
    std::vector<vec3> queries;
    const float radius = std::max(bounds.radius(), 1e-3f);
    for (size_t i = 0; i < count; ++i) {
        const vec3 p = points[random.next_bits() % points.size()];
        switch (i % 4) {
            case 0: queries.push_back(p); break;
            case 1: queries.push_back(p + 0.05f * radius * (in_cube(random) - 0.5f)); break;
            case 2: queries.push_back(bounds.min + in_cube(random) * bounds.diagonal()); break;
            default: queries.push_back(p + 10.0f * radius * (in_cube(random) - 0.5f)); break;
        }
    }
    return queries;
}

/// What find_nearest() promises, by a loop over all points.
void expect_nearest(const Built& built, const vec3& p, uint32_t k, float max_radius_m, Neighbours& found) {
    built.tree.find_nearest(p, k, max_radius_m, found);

    std::vector<float> distances_sq(built.points.size());
    for (uint32_t i = 0; i < built.points.size(); ++i) distances_sq[i] = built.distance_sq(p, i);
    std::vector<float> expected;
    std::copy_if(distances_sq.begin(), distances_sq.end(), std::back_inserter(expected),
                 [&](float d) { return d < max_radius_m * max_radius_m; });
    std::sort(expected.begin(), expected.end());
    const bool enough = expected.size() >= k;
    ASSERT_EQ(found.radius_m, enough ? std::sqrt(expected[k - 1]) : max_radius_m);
    if (enough) expected.resize(k - 1);

    std::vector<uint32_t> indices;
    std::vector<float> answers;
    for (const Neighbours::Found& neighbour : found.found) {
        ASSERT_LT(neighbour.index, built.points.size());
        ASSERT_EQ(neighbour.distance_sq_m2, distances_sq[neighbour.index]);
        indices.push_back(neighbour.index);
        answers.push_back(neighbour.distance_sq_m2);
    }
    std::sort(answers.begin(), answers.end());
    ASSERT_EQ(answers, expected);
    std::sort(indices.begin(), indices.end());
    ASSERT_EQ(std::adjacent_find(indices.begin(), indices.end()), indices.end()) << "a point was found twice";
}

TEST(KdTree, OrderIsAPermutationAndPositionsFollowIt) {
    for (const Cloud& cloud : clouds(1000)) {
        const Built built(cloud.points);
        std::vector<uint32_t> sorted = built.order, all(cloud.points.size());
        std::sort(sorted.begin(), sorted.end());
        std::iota(all.begin(), all.end(), 0u);
        ASSERT_EQ(sorted, all) << cloud.name;
        for (uint32_t i = 0; i < built.points.size(); ++i) ASSERT_EQ(built.tree.position(i), built.points[i]);
        EXPECT_EQ(built.tree.bytes(), KdTree::bytes_for(cloud.points.size()));
    }
}

TEST(KdTree, FindsTheNearestOfAnyCloud) {
    Neighbours found;
    for (const Cloud& cloud : clouds(3000)) {
        const Built built(cloud.points);
        for (const vec3& p : queries_for(cloud.points, 40))
            for (const uint32_t k : {2u, 7u, 50u, 500u, 3000u}) {
                expect_nearest(built, p, k, kInfinity, found);
                ASSERT_FALSE(HasFatalFailure())
                    << cloud.name << ", k = " << k << ", at " << p.x << " " << p.y << " " << p.z;
            }
    }
}

TEST(KdTree, KeepsToTheRadius) {
    Neighbours found;
    for (const Cloud& cloud : clouds(2000)) {
        const Built built(cloud.points);
        Bounds3 bounds;
        for (const vec3& p : cloud.points) bounds.extend(p);
        for (const vec3& p : queries_for(cloud.points, 40))
            for (const float share : {1e-6f, 1e-3f, 0.05f, 0.3f, 3.0f})
                for (const uint32_t k : {2u, 50u, 5000u}) {
                    expect_nearest(built, p, k, share * std::max(bounds.radius(), 1.0f), found);
                    ASSERT_FALSE(HasFatalFailure()) << cloud.name << ", k = " << k << ", radius share " << share;
                }
    }
}

TEST(KdTree, FindsAllWithinARadius) {
    Neighbours found;
    for (const Cloud& cloud : clouds(2000)) {
        const Built built(cloud.points);
        for (uint32_t i = 0; i < 50; ++i) {
            const vec3 p = cloud.points[i * 37 % cloud.points.size()];
            const float radius_m = glm::length(p - cloud.points[i]) * 1.1f + 1e-6f;
            built.tree.find_within(p, radius_m, found);
            std::vector<uint32_t> expected;
            for (uint32_t k = 0; k < built.points.size(); ++k)
                if (built.distance_sq(p, k) < radius_m * radius_m) expected.push_back(k);
            std::vector<uint32_t> indices;
            for (const Neighbours::Found& f : found.found) {
                indices.push_back(f.index);
                ASSERT_EQ(f.distance_sq_m2, built.distance_sq(p, f.index)) << cloud.name;
            }
            std::ranges::sort(indices);
            ASSERT_EQ(indices, expected) << cloud.name;
            ASSERT_EQ(found.radius_m, radius_m);
        }
    }
}

TEST(KdTree, ThePointAtTheRadiusIsNotNearer) {
    const std::vector<vec3> points = {vec3(0), vec3(1, 0, 0), vec3(2, 0, 0)};
    const Built built(points);
    Neighbours found;
    built.tree.find_nearest(vec3(0), 3, 2, found);
    EXPECT_EQ(found.found.size(), 2u);
    EXPECT_EQ(found.radius_m, 2);
    built.tree.find_nearest(vec3(0), 3, std::nextafter(2.0f, 3.0f), found);
    EXPECT_EQ(found.found.size(), 2u);  // the third is the k-th, and the radius
    EXPECT_EQ(found.radius_m, 2);
}

TEST(KdTree, SizesAboutK) {
    Neighbours found;
    for (const uint32_t k : {2u, 3u, 50u, kBucket})
        for (const uint32_t size : {1u, 2u, k - 1, k, k + 1}) {
            const std::vector<vec3> points = make_points(size, size, in_cube);
            const Built built(points);
            for (const vec3& p : queries_for(points, 20)) {
                if (size >= k) expect_nearest(built, p, k, kInfinity, found);
                expect_nearest(built, p, k, 100, found);
                expect_nearest(built, p, k, 0.2f, found);
                ASSERT_FALSE(HasFatalFailure()) << "k = " << k << ", size = " << size;
            }
        }
}

TEST(KdTree, SizesAboutBuckets) {
    Neighbours found;
    for (uint32_t buckets = 1; buckets <= 17; ++buckets)
        for (const uint32_t size : {buckets * kBucket - 1, buckets * kBucket, buckets * kBucket + 1}) {
            const std::vector<vec3> points = make_points(size, size, in_cube);
            const Built built(points);
            for (const vec3& p : queries_for(points, 12)) {
                expect_nearest(built, p, 10, kInfinity, found);
                expect_nearest(built, p, size, kInfinity, found);
                ASSERT_FALSE(HasFatalFailure()) << "size = " << size;
            }
        }
}

TEST(KdTree, EmptyTreeFindsNothing) {
    const KdTree trees[2] = {KdTree(), KdTree({}, {})};
    Neighbours found;
    for (const KdTree& tree : trees) {
        found.found.resize(5);
        tree.find_nearest(vec3(0), 50, 3, found);
        EXPECT_TRUE(found.found.empty());
        EXPECT_EQ(found.radius_m, 3);
        EXPECT_EQ(tree.find_one(vec3(0), kInfinity, [](uint32_t) { return true; }), 0u);
        EXPECT_EQ(tree.size(), 0u);
        EXPECT_EQ(tree.bytes(), 0u);
    }
}

TEST(KdTree, ManyCoincidentPoints) {
    std::vector<vec3> points(100'000, vec3(1, 2, 3));
    for (size_t i = 0; i < points.size(); i += 1000) points[i] = vec3(1, 2, 3 + 1e-4f * float(i));
    const Built built(points);
    Neighbours found;
    for (const vec3& p : {vec3(1, 2, 3), vec3(1, 2, 3.5f), vec3(0)})
        for (const uint32_t k : {2u, 50u, 2000u, 99'950u}) {
            expect_nearest(built, p, k, kInfinity, found);
            ASSERT_FALSE(HasFatalFailure()) << "k = " << k;
        }
}

TEST(KdTree, SameAnswersWhateverTheScratchHeld) {
    const std::vector<vec3> points = clouds(3000)[5].points;  // the lattice: which of the equally far are left out?
    const Built built(points);
    Neighbours used, fresh;
    for (const vec3& p : queries_for(points, 40)) {
        built.tree.find_nearest(p, 1000, kInfinity, used);
        built.tree.find_nearest(p, 50, kInfinity, used);
        fresh = {};
        built.tree.find_nearest(p, 50, kInfinity, fresh);
        ASSERT_EQ(used.radius_m, fresh.radius_m);
        ASSERT_EQ(used.found.size(), fresh.found.size());
        for (size_t i = 0; i < used.found.size(); ++i) ASSERT_EQ(used.found[i].index, fresh.found[i].index);
    }
}

TEST(KdTree, FindsTheNearestThatIsAccepted) {
    for (const Cloud& cloud : clouds(2000)) {
        const Built built(cloud.points);
        Bounds3 bounds;
        for (const vec3& p : cloud.points) bounds.extend(p);
        for (const vec3& p : queries_for(cloud.points, 60))
            for (const uint32_t one_in : {1u, 2u, 100u, 5000u})
                for (const float radius_m : {0.1f * std::max(bounds.radius(), 1.0f), kInfinity}) {
                    const auto accept = [&](uint32_t index) { return hash32(index) % one_in == 0; };
                    const uint32_t found = built.tree.find_one(p, radius_m, accept);
                    float expected = radius_m * radius_m;
                    bool any = false;
                    for (uint32_t i = 0; i < built.points.size(); ++i) {
                        if (!accept(i) || !(built.distance_sq(p, i) < expected)) continue;
                        expected = built.distance_sq(p, i);
                        any = true;
                    }
                    ASSERT_EQ(found != built.tree.size(), any) << cloud.name;
                    if (!any) continue;
                    ASSERT_TRUE(accept(found)) << cloud.name;
                    ASSERT_EQ(built.distance_sq(p, found), expected) << cloud.name;
                }
    }
}

TEST(KdTree, SameTreeForAnyNumberOfThreads) {
    for (const Cloud& cloud : clouds(150'000)) {
        if (cloud.name != "cube" && cloud.name != "lattice" && cloud.name != "plane") continue;
        const auto order = [&](int threads) {
            std::vector<uint32_t> indices(cloud.points.size());
            test::on_threads(threads, [&] { const KdTree tree(cloud.points, indices); });
            return indices;
        };
        ASSERT_EQ(order(1), order(2)) << cloud.name;
    }
}

}  // namespace
}  // namespace photond::kd_tree_test
