// Masses from points spread over crowded surfaces, against sums over the surfaces themselves; and that neither they nor
// the exact sums grow with the number of edges.

#include "renderer/photons/surface_samples.h"

#include <gtest/gtest.h>

#include "renderer/photons/boundary_tree.h"
#include "renderer/photons/surface_boundary.h"
#include "tests/support/rays.h"
#include "tests/support/statistics.h"
#include "tests/support/surface_scenes.h"
#include "tests/support/threads.h"

namespace photond::surface_samples_test {
namespace {

using test::kKernels;
using test::kUp;

// A sheet of 200 x 200 little squares: 7 of each 10 mm along both axes, 49 % of the whole.
constexpr int kSquares = 200;
constexpr float kPitch = 0.01f, kSide = 0.007f, kSheet = kSquares * kPitch;

enum class Winding { Up, Random, Both };

Mesh sheet(Winding winding) {
    MeshBuilder builder;
    RandomStream random(1, RandomDomain::Test, 0, 0);
    for (int y = 0; y < kSquares; ++y) {
        for (int x = 0; x < kSquares; ++x) {
            const vec2 min = kPitch * vec2(x, y), max = min + kSide;
            if (winding == Winding::Up || winding == Winding::Both || random.next() < 0.5f)
                test::add_floor(builder, min, max);
            else
                builder.quad({min.x, 0, min.y}, {max.x, 0, min.y}, {max.x, 0, max.y}, {min.x, 0, max.y});
        }
    }
    Mesh mesh = builder.build(0);
    if (winding == Winding::Both)
        for (const uvec3 t : std::vector<uvec3>(mesh.triangles)) mesh.triangles.push_back({t.x, t.z, t.y});
    return mesh;
}

SurfaceSamples samples_of(const Scene& scene, float radius_m) {
    const std::vector<BoundaryEdge> edges = find_boundary_edges(scene, *test::intersector_of(scene), radius_m);
    return SurfaceSamples(scene, edges, radius_m, position_error_m(scene), SurfaceBoundary::kDenseEdges);
}

/// The kernel's mass on the sheet and the sum of its square times the area [m^-2], from 25 points of each square.
struct Sums {
    double mass = 0, square_per_m2 = 0;

    Sums(const Kernel& kernel, vec2 at, float radius_m) {
        constexpr int kPoints = 5;
        const double share_m2 = double(kSide * kSide) / (kPoints * kPoints);
        const auto first = [&](float x) { return std::max(0, static_cast<int>((x - radius_m) / kPitch) - 1); };
        const auto last = [&](float x) {
            return std::min(kSquares - 1, static_cast<int>((x + radius_m) / kPitch) + 1);
        };
        for (int y = first(at.y); y <= last(at.y); ++y) {
            for (int x = first(at.x); x <= last(at.x); ++x) {
                for (int i = 0; i < kPoints * kPoints; ++i) {
                    const vec2 in_square = (vec2(i % kPoints, i / kPoints) + 0.5f) / static_cast<float>(kPoints);
                    const vec2 to = kPitch * vec2(x, y) + kSide * in_square - at;
                    const float q_sq = glm::dot(to, to) / sqr(radius_m);
                    if (q_sq >= 1) continue;
                    const double density = double(kernel(q_sq) / sqr(radius_m));
                    mass += density * share_m2, square_per_m2 += density * density * share_m2;
                }
            }
        }
    }
};

TEST(SurfaceSamples, FindTheShareOfASheetOfLittleSquares) {
    // Were samples chosen independently, one of area a for each a on the average, a mass would have the variance a
    // times the integral of the kernel's square; being spread evenly takes away from that. Choosing them twice, first
    // one for each a / 4, adds a quarter.
    constexpr double kFalseAlarm = 1e-6;
    constexpr double kMustDetect = 0.15;  // of the mean of all places
    constexpr float kRadius = 0.2f;       // of the first level
    const double a_of_first_m2 = double(kPi * sqr(kRadius)) / 128;
    for (const Winding winding : {Winding::Up, Winding::Random, Winding::Both}) {
        const Scene scene = test::scene_of({sheet(winding)});
        const SurfaceSamples samples = samples_of(scene, kRadius);
        for (const float radius : {0.2f, 0.11f, 0.1f, 0.06f}) {
            const double area_m2 = radius > 0.1f ? a_of_first_m2 : a_of_first_m2 / 4;
            for (const bool at_rim : {false, true}) {
                if (at_rim && radius <= 0.1f) continue;  // half as many edges are not dense
                // Discs that do not overlap; in the corners edges are fewer.
                constexpr float kMargin = 0.3f;
                std::vector<vec2> places;
                const float last = at_rim ? 0 : kSheet - kMargin;
                for (float x = at_rim ? 0 : kMargin; x <= last; x += 2 * radius)
                    for (float y = kMargin; y <= kSheet - kMargin; y += 2 * radius) places.push_back({x + 1e-3f, y});
                for (const Kernel& kernel : kKernels) {
                    double difference = 0, square = 0, variance = 0, mass = 0;
                    for (const vec2& at : places) {
                        const vec3 p(at.x, 0, at.y);
                        ASSERT_TRUE(samples.cover(p, radius));
                        const Sums sums(kernel, at, radius);
                        const double off = double{samples.mass(kernel, p, kUp, radius, radius / 4).mass} - sums.mass;
                        difference += off, square += off * off, mass += sums.mass;
                        variance += 1.25 * area_m2 * sums.square_per_m2;
                    }
                    const auto count = static_cast<double>(places.size());
                    const double z = test::two_sided_z(test::share_of_false_alarm(kFalseAlarm, 3 * 4 * 2 * 5 * 2));
                    EXPECT_LE(std::abs(difference), z * std::sqrt(variance))
                        << test::name_of(kernel) << ", radius " << radius << ", rim " << at_rim;
                    EXPECT_LE(square, variance * (1 + z * std::sqrt(2 / count))) << test::name_of(kernel);
                    EXPECT_NEAR(mass / count, at_rim ? 0.245 : 0.49, 0.03) << "the places are not what is meant";
                    if (radius == 0.1f) {
                        EXPECT_LE(z * std::sqrt(variance), kMustDetect * mass) << "too noisy to notice a defect";
                    }
                }
            }
        }
    }
}

TEST(SurfaceSamples, SheetsOneAboveTheOtherAreNoMoreThanAWholeDisc) {
    // Twenty sheets, a millimetre apart: together far more than the disc.
    MeshBuilder builder;
    for (int level = 0; level < 20; ++level)
        for (int y = 0; y < 40; ++y)
            for (int x = 0; x < 40; ++x)
                test::add_floor(builder, kPitch * vec2(x, y), kPitch * vec2(x, y) + kSide,
                                1e-3f * static_cast<float>(level));
    const Scene scene = test::scene_of({builder.build(0)});
    const SurfaceBoundary boundary(scene, *test::intersector_of(scene), 0.1f);
    EXPECT_GT(boundary.samples(), 0u);
    for (const Kernel& kernel : kKernels)
        EXPECT_EQ(boundary.mass_on_surface(kernel, {0.2f, 0.01f, 0.2f}, kUp, 0.1f, 0.025f), 1) << test::name_of(kernel);
}

TEST(SurfaceSamples, LookUpsDoNotGrowWithTheNumberOfEdges) {
    constexpr float kRadius = 0.16f;
    for (const int count : {1000, 4000}) {  // 24,000 and 96,000 edges within the radius
        const Scene scene = test::scene_of({test::floor_mesh({-2, -2}, {2, 2}), test::chips(count, 0.14f, 0.06f)});
        const std::vector<BoundaryEdge> edges = find_boundary_edges(scene, *test::intersector_of(scene), kRadius);
        const SurfaceSamples samples(scene, edges, kRadius, position_error_m(scene), SurfaceBoundary::kDenseEdges);
        const BoundaryTree tree(edges, kRadius);
        RandomStream random(6, RandomDomain::Test, 0, 0);
        size_t limited = 0;
        for (int i = 0; i < 3000; ++i) {
            const float radius = kRadius * std::pow(0.03f, random.next());
            const vec3 p(0.5f * random.next() - 0.25f, 0.07f * random.next(), 0.5f * random.next() - 0.25f);
            const vec3 normal = glm::normalize(vec3(random.next() - 0.5f, random.next() - 0.5f, random.next() - 0.5f));
            size_t blocks = 0;
            const bool covered = samples.cover(p, radius);
            const bool all = tree.visit_blocks(p, normal, radius, radius / 4,
                                               covered ? BoundaryTree::Limit::Limited : BoundaryTree::Limit::None,
                                               [&](const EdgeBlock&) { ++blocks; });
            EXPECT_TRUE(all || blocks == 0);
            EXPECT_LE(blocks, covered ? BoundaryTree::kMostBlocks : SurfaceBoundary::kDenseEdges / kLanes);
            if (all) continue;
            ++limited;
            const auto [mass, looked_at] = samples.mass(kKernels[0], p, normal, radius, radius / 4);
            EXPECT_LE(looked_at, 2 * SurfaceSamples::kMostOfCell) << "the ball fills half of a cell";
            EXPECT_TRUE(mass >= 0 && mass < 100);
        }
        EXPECT_GT(limited, 100u) << "nothing is tested";
    }
}

TEST(SurfaceSamples, FloorBesideAHeapIsAWholeDisc) {
    const Scene scene = test::heap_on_a_floor();
    const SurfaceBoundary boundary(scene, *test::intersector_of(scene), 0.16f);
    EXPECT_GT(boundary.samples(), 0u);
    const SurfaceSamples samples = samples_of(scene, 0.16f);
    size_t covered = 0;
    for (int i = 0; i < 200; ++i) {
        const float angle = 0.1f * static_cast<float>(i), reach = 0.32f + 1e-3f * static_cast<float>(i);
        const vec3 p(reach * std::cos(angle), 0, reach * std::sin(angle));
        covered += samples.cover(p, 0.16f);
        for (const Kernel& kernel : kKernels) EXPECT_EQ(boundary.mass_on_surface(kernel, p, kUp, 0.16f, 0.04f), 1);
    }
    EXPECT_GT(covered, 0u) << "no place near the heap";
}

TEST(SurfaceSamples, AreNotMadeWhereEdgesAreFew) {
    const Scene box = test::scene_of({MeshBuilder().box({0, 0, 0}, {1, 1, 1}).build(0)});
    const Scene far_apart = test::scene_of({sheet(Winding::Up)});
    EXPECT_EQ(SurfaceBoundary(box, *test::intersector_of(box), 0.5f).samples(), 0u);
    const SurfaceBoundary small(far_apart, *test::intersector_of(far_apart), 0.03f);
    EXPECT_GT(small.edges(), SurfaceBoundary::kDenseEdges);
    EXPECT_EQ(small.samples(), 0u);
    EXPECT_EQ(SurfaceSamples(box, {}, 1, 0, 0).size(), 0u);
}

TEST(SurfaceSamples, AreTheSameForAnyNumberOfThreads) {
    const Scene scene = test::heap_on_a_floor();
    const auto make = [&](int threads) { return test::on_threads(threads, [&] { return samples_of(scene, 0.16f); }); };
    const SurfaceSamples one = make(1), many = make(4);
    EXPECT_GT(one.size(), 1000u);
    EXPECT_EQ(one.size(), many.size());
    EXPECT_EQ(one.bytes(), many.bytes());
    RandomStream random(7, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 1000; ++i) {
        const vec3 p(0.4f * random.next() - 0.2f, 0.07f * random.next(), 0.4f * random.next() - 0.2f);
        const float radius = 0.16f * (0.1f + 0.9f * random.next());
        ASSERT_EQ(one.cover(p, radius), many.cover(p, radius));
        if (!one.cover(p, radius)) continue;
        EXPECT_EQ(one.mass(kKernels[4], p, kUp, radius, radius / 4).mass,
                  many.mass(kKernels[4], p, kUp, radius, radius / 4).mass);
    }
}

}  // namespace
}  // namespace photond::surface_samples_test
