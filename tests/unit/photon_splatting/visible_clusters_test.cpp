// Clusters of visible points: every point in one of them, every cluster within a beam found, once.

#include "renderer/methods/photon_splatting/visible_clusters.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "renderer/core/rng.h"
#include "renderer/transport/sampling.h"

namespace photond::visible_clusters_test {
namespace {

constexpr uint32_t kMaxScatterings = 6;
constexpr Size2 kFilm{70, 50};
constexpr Tile kTile{32, 32, 64, 50};

vec3 random_direction(RandomStream& random) {
    const vec3 w = sample_cosine_hemisphere(random.next_2d());
    return random.next() < 0.5f ? w : -w;
}

enum class Surface { Flat, Wavy, Scattered };

/// Where a pixel looks, and its normals.
struct Seen {
    vec3 position, geometric_normal, normal;
};
Seen seen_at(Surface surface, uint32_t pixel, RandomStream& random) {
    const vec2 at(static_cast<float>(pixel % kFilm.width), static_cast<float>(pixel / kFilm.width));
    switch (surface) {
        case Surface::Flat: return {vec3(0.1f * at.x, 2, 0.1f * at.y), vec3(0, 1, 0), vec3(0, 1, 0)};
        case Surface::Wavy: {
            const vec3 position(0.1f * at.x, std::sin(0.3f * at.x), 0.1f * at.y);
            const vec3 normal = glm::normalize(vec3(-3 * std::cos(0.3f * at.x), 1, 0));
            return {position, normal, glm::normalize(normal + vec3(0, 0.1f, 0.1f))};
        }
        case Surface::Scattered: break;
    }
    const vec3 normal = random_direction(random);
    return {vec3(random.next(), random.next(), random.next()) * 5.0f, normal, normal};
}

/// Points of both kinds, told apart by their first weight: 1, 2, 3 ...
struct Points {
    std::vector<LambertVisiblePoint> lambert;
    std::vector<VisiblePoint> others;
    std::vector<Seen> seen;  // by number, from 1 on
    std::vector<uint32_t> scatterings, pixels;
};

Points make_points(Surface surface, size_t count, uint32_t most_scatterings, uint64_t seed) {
    RandomStream random(seed, RandomDomain::Test, 0, 0);
    Points points;
    points.seen.resize(1), points.scatterings.resize(1), points.pixels.resize(1);
    for (size_t i = 1; i <= count; ++i) {
        const auto below = [&](uint32_t n) { return std::min(static_cast<uint32_t>(random.next() * float(n)), n - 1); };
        const uint32_t pixel =
            (kTile.y0 + below(kTile.y1 - kTile.y0)) * kFilm.width + kTile.x0 + below(kTile.x1 - kTile.x0);
        const Seen seen = seen_at(surface, pixel, random);
        const uint32_t scatterings = below(most_scatterings + 1);
        points.seen.push_back(seen), points.scatterings.push_back(scatterings), points.pixels.push_back(pixel);
        if (random.next() < 0.6f) {
            LambertVisiblePoint point{};
            point.position = seen.position;
            point.geometric_normal = seen.geometric_normal, point.normal = seen.normal;
            point.weight = Rgb(kPi * float(i), 0, 0);
            point.pixel = pixel, point.scatterings = scatterings;
            points.lambert.push_back(point);
        } else {
            VisiblePoint point{};
            point.surface.position = seen.position;
            point.surface.geometric_normal = seen.geometric_normal, point.surface.shading = Frame(seen.normal);
            point.throughput = Rgb(float(i), 0, 0);
            point.pixel = pixel, point.scatterings = scatterings;
            points.others.push_back(point);
        }
    }
    return points;
}

struct Clustered {
    PointTile tile;
    std::vector<VisibleCluster> clusters;
};
Clustered cluster(const Points& points, float split_extent_m) {
    Clustered made;
    ClusterBuilder builder;
    builder.start(kTile, 7, kFilm, kMaxScatterings, split_extent_m, made.tile, made.clusters);
    // As the walk does: vertex by vertex, one of the kinds at times.
    const size_t half = points.lambert.size() / 2;
    builder.take(std::span(points.lambert).first(half), points.others);
    builder.take(std::span(points.lambert).subspan(half), {});
    builder.take({}, {});
    return made;
}

size_t number_at(const Clustered& made, const VisibleCluster& cluster, uint32_t i) {
    const PointBlock& block = made.tile.blocks[cluster.first_block + i / uint32_t{kLanes}];
    return static_cast<size_t>(std::lround(block.weight.get(i % kLanes).x));
}

struct Arrangement {
    Surface surface;
    size_t count;
    uint32_t most_scatterings;
    float split_extent_m;
};
constexpr Arrangement kArrangements[] = {
    {Surface::Flat, 0, 0, 1},           {Surface::Flat, 1, 0, 1},        {Surface::Flat, 576, 0, 1e9f},
    {Surface::Flat, 3000, 2, 1e9f},     {Surface::Wavy, 576, 3, 0.3f},   {Surface::Wavy, 1000, 200, 0.5f},
    {Surface::Scattered, 700, 1, 0.2f}, {Surface::Scattered, 700, 0, 0},
};

TEST(ClusterBuilder, EveryPointIsInOneClusterThatHoldsIt) {
    for (const Arrangement& arranged : kArrangements) {
        const Points points = make_points(arranged.surface, arranged.count, arranged.most_scatterings, 1);
        const Clustered made = cluster(points, arranged.split_extent_m);
        std::vector<int> times(arranged.count + 1, 0);
        for (const VisibleCluster& at : made.clusters) {
            EXPECT_EQ(at.tile, 7u);
            ASSERT_GT(at.points, 0u);
            ASSERT_LE(at.points, VisibleCluster::kMostPoints);
            uint32_t most_before = 0;
            for (uint32_t i = 0; i < at.points; ++i) {
                const PointBlock& block = made.tile.blocks[at.first_block + i / uint32_t{kLanes}];
                const size_t lane = i % kLanes, number = number_at(made, at, i);
                ASSERT_GE(number, 1u);
                ASSERT_LE(number, arranged.count);
                ++times[number];
                const Seen& seen = points.seen[number];
                EXPECT_EQ(block.position.get(lane), seen.position);
                EXPECT_EQ(block.geometric_normal.get(lane), seen.geometric_normal);
                EXPECT_EQ(block.normal.get(lane), at.general ? Frame(seen.normal).normal : seen.normal);
                EXPECT_EQ(block.pixel[lane], points.pixels[number]);
                EXPECT_EQ(block.sum.get(lane), vec3(0));
                EXPECT_EQ(block.splats[lane], 0);
                if (at.general) {
                    ASSERT_LT(block.general[lane], made.tile.general.size());
                    EXPECT_EQ(made.tile.general[block.general[lane]].throughput.x, float(number));
                }
                most_before = std::max(most_before, points.scatterings[number]);
                const vec3 from_centre = seen.position - at.target.centre;
                EXPECT_LE(glm::length(from_centre), at.target.radius_m);
                for (int axis = 0; axis < 3; ++axis)
                    EXPECT_LE(std::fabs(from_centre[axis]), at.target.half[axis] * 1.0001f);
                if (at.flat()) {
                    EXPECT_LT(glm::distance(at.target.normal, seen.geometric_normal), 1e-5f);
                    EXPECT_LT(glm::distance(at.target.normal, seen.normal), 1e-5f);
                    EXPECT_LT(std::fabs(glm::dot(at.target.normal, from_centre)), 1e-4f);
                }
            }
            // The eye's path and the last scattering, at the point, are taken off.
            EXPECT_EQ(at.most_scatterings, kMaxScatterings - std::min(kMaxScatterings, most_before + 1));
            // Whatever lies behind the last point no splat may reach.
            for (uint32_t i = at.points; i < at.blocks() * kLanes; ++i)
                EXPECT_GT(made.tile.blocks[at.first_block + i / uint32_t{kLanes}].position.get(i % kLanes).x, 1e17f);
            if (arranged.most_scatterings < 64) {
                for (uint32_t i = 0; i < at.points; ++i)
                    EXPECT_EQ(points.scatterings[number_at(made, at, i)], most_before);
            }
        }
        EXPECT_TRUE(std::all_of(times.begin() + 1, times.end(), [](int n) { return n == 1; }));
    }
}

TEST(ClusterBuilder, WideClustersAreHalvedDownToTheLanes) {
    for (const Arrangement& arranged : kArrangements) {
        const Points points = make_points(arranged.surface, arranged.count, arranged.most_scatterings, 2);
        for (const VisibleCluster& at : cluster(points, arranged.split_extent_m).clusters)
            if (at.points > kLanes) {
                // The target's half is to the farther end.
                EXPECT_LE(max_component(at.target.half), arranged.split_extent_m * 1.0001f);
            }
    }
}

TEST(ClusterBuilder, FlatSurfacesMakeFlatClusters) {
    const Points points = make_points(Surface::Flat, 576, 0, 3);
    for (const VisibleCluster& at : cluster(points, 1e9f).clusters) EXPECT_TRUE(at.flat());
    size_t flat = 0;
    const Clustered wavy = cluster(make_points(Surface::Wavy, 576, 0, 3), 1e9f);
    for (const VisibleCluster& at : wavy.clusters) flat += at.flat() && at.points > kLanes;
    EXPECT_EQ(flat, 0u);
}

// --- the tree

/// Clusters of a random sheet of points, and their points.
struct Field {
    VisibleClusters tree;
    std::vector<std::vector<vec3>> points;  // by the tree's cluster index
    Bounds3 bounds;
};
Field make_field(size_t count, uint64_t seed) {
    RandomStream random(seed, RandomDomain::Test, 1, 0);
    std::vector<VisibleCluster> clusters;
    std::vector<std::vector<vec3>> points(count);
    Field field;
    for (size_t i = 0; i < count; ++i) {
        const vec3 middle = 10.0f * vec3(random.next(), random.next(), random.next());
        const vec3 normal = random.next() < 0.5f ? vec3(0, 1, 0) : random_direction(random);
        const Frame frame(normal);
        Bounds3 box;
        for (int k = 0; k < 9; ++k) {
            const vec2 across = 0.4f * (random.next_2d() - 0.5f);
            points[i].push_back(middle + across.x * frame.tangent + across.y * frame.bitangent);
            box.extend(points[i].back());
            field.bounds.extend(points[i].back());
        }
        VisibleCluster made;
        made.target = {box.centre(), 0.5f * box.diagonal(), 0, vec3(0)};
        for (const vec3& p : points[i])
            made.target.radius_m = std::max(made.target.radius_m, 1.0001f * glm::distance(p, made.target.centre));
        made.first_block = static_cast<uint32_t>(i);
        made.splat_radius_m = random.next();
        clusters.push_back(made);
    }
    field.tree.build(std::move(clusters), field.bounds);
    for (const VisibleCluster& made : field.tree.clusters()) field.points.push_back(points[made.first_block]);
    return field;
}

double distance_to(const VisibleClusters::Beam& beam, const vec3& p) {
    const dvec3 d = dvec3(p) - dvec3(beam.origin);
    const double t = std::clamp(glm::dot(d, dvec3(beam.axis)), double{beam.near_m}, double{beam.far_m});
    return glm::length(d - t * dvec3(beam.axis));
}

VisibleClusters::Beam random_beam(RandomStream& random) {
    VisibleClusters::Beam beam{12.0f * vec3(random.next(), random.next(), random.next()) - 1.0f,
                               random_direction(random)};
    beam.radius_m = 2 * random.next() * random.next();
    if (random.next() < 0.5f) std::swap(beam.radius, beam.radius_m);  // over the clusters' own
    if (random.next() < 0.5f) {
        beam.near_m = 3 * random.next();
        beam.far_m = beam.near_m + 4 * random.next();
    }
    return beam;
}

constexpr auto kEnterAll = [](const ShaftTarget&, int state) { return state; };

TEST(VisibleClusters, FindsEveryClusterWithAPointInTheBeamOnce) {
    RandomStream random(5, RandomDomain::Test, 0, 0);
    uint64_t found_in_all = 0, within_in_all = 0;
    for (const size_t count : {size_t{0}, size_t{1}, kLanes, kLanes + 1, size_t{100}, size_t{3000}}) {
        const Field field = make_field(count, count + 1);
        ASSERT_EQ(field.tree.clusters().size(), count);
        for (int i = 0; i < 200; ++i) {
            const VisibleClusters::Beam beam = random_beam(random);
            std::vector<int> times(count, 0);
            field.tree.find(beam, 3, kEnterAll, [&](uint32_t index, int state) {
                EXPECT_EQ(state, 3);
                ++times[index];
            });
            for (size_t k = 0; k < count; ++k) {
                EXPECT_LE(times[k], 1);
                const VisibleCluster& at = field.tree.clusters()[k];
                const float reach_m = beam.radius_m + beam.radius * at.splat_radius_m;
                const bool within = std::any_of(field.points[k].begin(), field.points[k].end(), [&](const vec3& p) {
                    return distance_to(beam, p) < double{reach_m} - 1e-5;
                });
                if (within) {
                    EXPECT_EQ(times[k], 1) << "of " << count << " clusters";
                }
                // And none for nothing.
                if (times[k]) {
                    EXPECT_LE(distance_to(beam, at.target.centre), reach_m + at.target.radius_m + 1e-4f);
                }
                found_in_all += static_cast<uint64_t>(times[k]);
                within_in_all += within;
            }
        }
    }
    EXPECT_GT(within_in_all, 1000u);
    EXPECT_GE(found_in_all, within_in_all);
}

TEST(VisibleClusters, TheOrderDependsOnNothingElse) {
    const Field field = make_field(1000, 9), again = make_field(1000, 9);
    RandomStream random(6, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 50; ++i) {
        const VisibleClusters::Beam beam = random_beam(random);
        std::vector<uint32_t> first, second;
        field.tree.find(beam, 0, kEnterAll, [&](uint32_t index, int) { first.push_back(index); });
        again.tree.find(beam, 0, kEnterAll, [&](uint32_t index, int) { second.push_back(index); });
        EXPECT_EQ(first, second);
    }
}

// Going down, each target holds the points of what it is of; what a parent said its children are told.
TEST(VisibleClusters, StatesComeFromTheParentsAndNegativeOnesLeaveOut) {
    const Field field = make_field(3000, 11);
    const VisibleClusters::Beam everything{vec3(5), vec3(0, 0, 1), 0, kInfinity, 100};
    // Counts the levels: all leaves lie equally deep.
    int depth = 0;
    uint64_t leaves = 0;
    field.tree.find(
        everything, 0, [](const ShaftTarget&, int state) { return state + 1; },
        [&](uint32_t, int state) {
            depth = std::max(depth, state);
            EXPECT_EQ(state, depth);
            ++leaves;
        });
    EXPECT_EQ(leaves, 3000u);
    EXPECT_GE(depth, 4);
    // What lies below a plane is left out, node by node, without losing any above.
    std::vector<int> times(3000, 0);
    uint64_t entered = 0;
    field.tree.find(
        everything, 0,
        [&](const ShaftTarget& target, int) {
            ++entered;
            return target.centre.y + target.half.y < 5 ? -1 : 0;
        },
        [&](uint32_t index, int) { ++times[index]; });
    for (size_t k = 0; k < 3000; ++k) {
        const bool above =
            std::any_of(field.points[k].begin(), field.points[k].end(), [](const vec3& p) { return p.y > 5.001f; });
        if (above) {
            EXPECT_EQ(times[k], 1);
        }
    }
    EXPECT_LT(entered, 3000u);
}

TEST(VisibleClusters, ManyInOnePlaceMakeATree) {
    std::vector<VisibleCluster> clusters(500);
    for (VisibleCluster& at : clusters) at.target = {vec3(1, 2, 3), vec3(0), 0, vec3(0, 1, 0)};
    VisibleClusters tree;
    tree.build(std::move(clusters), {vec3(1, 2, 3), vec3(1, 2, 3)});
    uint64_t found = 0;
    tree.find({vec3(1, 2, 0), vec3(0, 0, 1), 0, kInfinity, 0.1f}, 0, kEnterAll, [&](uint32_t, int) { ++found; });
    EXPECT_EQ(found, 500u);
    found = 0;
    tree.find({vec3(1, 2, 0), vec3(0, 0, -1), 0, kInfinity, 0.1f}, 0, kEnterAll, [&](uint32_t, int) { ++found; });
    EXPECT_EQ(found, 0u);
}

}  // namespace
}  // namespace photond::visible_clusters_test
