// How much of a disc lies on surface that light can reach: closed forms, and what real rooms hold.

#include "renderer/photons/disc_coverage.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <atomic>

#include "renderer/photons/surface_edges.h"
#include "renderer/photons/world_triangles.h"
#include "renderer/scene/intersector.h"
#include "tests/support/rays.h"
#include "tests/support/statistics.h"
#include "tests/support/surface_scenes.h"

namespace photond::disc_coverage_test {
namespace {

using test::add_floor;
using test::floor_mesh;
using test::kKernels;
using test::kUp;
using test::name_of;
using test::scene_of;

constexpr double kFalseAlarm = 1e-6;
constexpr size_t kChecks = 100;  // of all tests here

/// Counts the rays that are asked for.
class CountingIntersector final : public Intersector {
public:
    explicit CountingIntersector(const Intersector& inner) : inner_(inner) {}
    Hit closest_hit(const Ray& ray) const override { return ++rays, inner_.closest_hit(ray); }
    bool occluded(const Ray& ray) const override { return ++rays, inner_.occluded(ray); }
    void closest_hits(std::span<const Ray> batch, std::span<Hit> hits, Coherence coherence) const override {
        rays += batch.size();
        inner_.closest_hits(batch, hits, coherence);
    }
    void occluded(std::span<const Ray> batch, std::span<uint8_t> occluded, Coherence coherence) const override {
        rays += batch.size();
        inner_.occluded(batch, occluded, coherence);
    }
    uint64_t bytes() const override { return inner_.bytes(); }

    mutable std::atomic<size_t> rays = 0;

private:
    const Intersector& inner_;
};

/// A scene and what discs on it are asked.
struct Place {
    explicit Place(Scene of, float radius)
        : scene(std::move(of)),
          intersector(test::intersector_of(scene)),
          counting(*intersector),
          radius_m(radius),
          coverage(scene, counting, radius) {}

    DiscProbe::Mass at(const vec3& p, const vec3& normal = kUp, const Kernel& kernel = Kernel(),
                       DiscCare care = DiscCare::Fine) const {
        if (!coverage.may_be_cut(p, radius_m)) return {};
        return DiscProbe(coverage, kernel, {p, normal, radius_m, 0.25f * radius_m},
                         static_cast<uint32_t>(hash_position(p)), care)
            .mass();
    }
    /// Mean of 1 / m over places along `along` from p, which all have the same m.
    void expect_mass(double mass, const vec3& p, const vec3& along, const vec3& normal = kUp,
                     const Kernel& kernel = Kernel()) const {
        for (const DiscCare care : {DiscCare::Fine, DiscCare::Coarse}) {
            test::RunningMean inverse;
            for (int i = 0; i < 2000; ++i)
                inverse.add(double{at(p + (static_cast<float>(i) / 2000) * along, normal, kernel, care).inverse});
            const double z = test::two_sided_z(test::share_of_false_alarm(kFalseAlarm, kChecks));
            EXPECT_LE(std::abs(inverse.mean() - 1 / mass), z * inverse.standard_error() + 1e-9)
                << name_of(kernel) << (care == DiscCare::Fine ? ", fine: " : ", coarse: ") << inverse.mean() << " for "
                << 1 / mass;
            EXPECT_LE(z * inverse.standard_error(), 0.05 / mass) << "too noisy to notice a defect";
        }
    }

    Scene scene;
    std::unique_ptr<Intersector> intersector;
    CountingIntersector counting;
    float radius_m;
    DiscCoverage coverage;
};

/// The kernel's mass beyond a line at distance q (of the radius), by a sum over a fine division of the angle.
double mass_beyond_line(const Kernel& kernel, double q) {
    constexpr int kSteps = 20000;
    const double last = std::acos(q);
    double sum = 0;
    for (int i = 0; i < kSteps; ++i)
        sum += 1 - double{kernel.mass_within(static_cast<float>(q / std::cos(last * (i + 0.5) / kSteps)))};
    return sum * last / kSteps / 3.14159265358979;
}

TEST(DiscCoverage, StraightEdgeByTheClosedForm) {
    const Place place(scene_of({floor_mesh({0, 0}, {1, 1})}), 0.2f);
    for (const Kernel& kernel : kKernels)
        for (const float q : {0.02f, 0.3f, 0.7f})
            place.expect_mass(1 - mass_beyond_line(kernel, double{q}), {0.2f * q, 0, 0.3f}, {0, 0, 0.4f}, kUp, kernel);
}

TEST(DiscCoverage, WholeDiscsAreExactAndFarFromEdgesTakeNoRay) {
    // A cellar below a part of the floor, whose edges are near and cut nothing.
    const Place place(
        scene_of({floor_mesh({-2, -2}, {2, 2}), MeshBuilder().box({0, -0.5f, 0.25f}, {1, -0.12f, 0.35f}).build(0)}),
        0.2f);
    const size_t before = place.counting.rays;
    for (int i = 0; i < 100; ++i) EXPECT_EQ(place.at({1.79f - 0.01f * static_cast<float>(i), 0, -1}).inverse, 1.0f);
    EXPECT_EQ(place.counting.rays, before);
    for (int i = 0; i < 100; ++i) {
        const size_t rays = place.counting.rays;
        const auto found = place.at({0.01f * static_cast<float>(i), 0, 0.3f});
        EXPECT_EQ(found.inverse, 1.0f);
        EXPECT_FALSE(found.hides);
        EXPECT_GT(place.counting.rays, rays);
        EXPECT_LE(place.counting.rays - rays, 1 + DiscProbe::kMostInBatch);
    }
}

TEST(DiscCoverage, NeedleOfSurfaceIsTheLeastMassAtABoundedNumberOfRays) {
    const Place place(scene_of({floor_mesh({-1, -1e-4f}, {1, 1e-4f})}), 0.5f);
    const size_t before = place.counting.rays;
    EXPECT_EQ(place.at({0, 0, 0}).inverse, 1 / DiscCoverage::kLeastMass);
    EXPECT_LE(place.counting.rays - before, 1 + 3 * DiscProbe::kMostPlaces);
}

TEST(DiscCoverage, TwoSheetsThatEndAtOnePlaceAreTakenAwayOnce) {
    // A wall, and before it a board of 1 cm, both from the floor up: seen from either the disc ends at the floor.
    MeshBuilder room;
    add_floor(room, {-1, 0}, {1, 1});
    room.quad({-1, 0, 0}, {1, 0, 0}, {1, 2, 0}, {-1, 2, 0});
    const Mesh walls = room.build(0), board = MeshBuilder().box({-1, 0, 0}, {1, 0.15f, 0.01f}).build(0);
    const Kernel kernel;
    const vec3 out(0, 0, 1);
    const Place small(scene_of({walls, board}), 0.08f), wide(scene_of({walls, board}), 0.2f);
    small.expect_mass(1 - mass_beyond_line(kernel, 0.3), {-0.6f, 0.024f, 0.01f}, {1.2f, 0, 0}, out);
    wide.expect_mass(1 - mass_beyond_line(kernel, 0.8), {-0.6f, 0.16f, 0}, {1.2f, 0, 0}, out);
}

TEST(DiscCoverage, FloorBelowABoxAndBehindAPartitionDoesNotCount) {
    for (const bool partition : {false, true}) {
        MeshBuilder thing;
        if (partition)
            thing.quad({0, 0, 1}, {0, 0, -1}, {0, 1, -1}, {0, 1, 1});
        else
            thing.box({0, 0, -1}, {0.8f, 1, 1});
        const Place place(scene_of({floor_mesh({-1, -1}, {1, 1}), thing.build(0)}), 0.2f);
        place.expect_mass(1 - mass_beyond_line(Kernel(), 0.2), {-0.04f, 0, -0.5f}, {0, 0, 1});
        const auto found = place.at({-0.04f, 0, 0});
        EXPECT_TRUE(found.hides);
        const Kernel kernel;
        const CoverageDisc disc{{-0.04f, 0, 0}, kUp, 0.2f, 0.05f};
        const DiscProbe probe(place.coverage, kernel, disc, 0, DiscCare::Fine);
        EXPECT_TRUE(probe.sees({-0.1f, 0, 0.1f}));
        EXPECT_FALSE(probe.sees({0.1f, 0, 0.1f}));
    }
}

TEST(DiscCoverage, RimOfACarpetDoesNotCountWhereTheFloorIsWithinTheDisc) {
    // Half of the carpet hangs over the end of the floor.
    const Place place(scene_of({floor_mesh({0, 0}, {2, 2}), floor_mesh({0.5f, 0.5f}, {1.5f, 3}, 0.01f)}), 0.2f);
    for (const float z : {0.9f, 1.0f, 1.1f}) {
        EXPECT_LT(place.at({0.55f, 0.01f, z}).inverse, 1.3f) << "on the carpet, whose rim hides a strip of floor";
        EXPECT_LT(place.at({0.45f, 0, z}).inverse, 1.3f) << "beside it";
    }
    place.expect_mass(1 - mass_beyond_line(Kernel(), 0.25), {0.55f, 0.01f, 2.3f}, {0, 0, 0.4f});  // no floor below
    // The floor is too far below for the disc's thickness.
    const Kernel kernel;
    test::RunningMean inverse;
    for (int i = 0; i < 500; ++i) {
        const CoverageDisc disc{{0.55f, 0.01f, 0.8f + 0.001f * static_cast<float>(i)}, kUp, 0.2f, 0.008f};
        const uint32_t turn = static_cast<uint32_t>(i) * 0x9e3779b9u;
        inverse.add(double{DiscProbe(place.coverage, kernel, disc, turn, DiscCare::Fine).mass().inverse});
    }
    EXPECT_NEAR(inverse.mean(), 1 / (1 - mass_beyond_line(Kernel(), 0.25)), 6 * inverse.standard_error());
}

TEST(DiscCoverage, SurfaceTurnedMoreThanSixtyDegreesDoesNotCount) {
    const Place place(scene_of({MeshBuilder().box({0, 0, 0}, {1, 1, 1}).build(0)}), 0.3f);
    for (const vec3& normal : {kUp, -kUp})  // of the bottom, from inside and from below
        place.expect_mass(1 - mass_beyond_line(Kernel(), 0.3), {0.09f, 0, 0.35f}, {0, 0, 0.3f}, normal);
}

TEST(SurfaceEdges, AreThoseWhereASurfaceDoesNotGoOnStraight) {
    const auto count = [](const Scene& scene, float radius_m) { return find_surface_edges(scene, radius_m).size(); };
    EXPECT_EQ(count(scene_of({floor_mesh({0, 0}, {1, 1})}), 0.3f), 4u);
    EXPECT_EQ(count(scene_of({floor_mesh({0, 0}, {1, 1}), floor_mesh({0, 0}, {1, 1})}), 0.3f), 4u) << "coincident";
    EXPECT_EQ(count(scene_of({MeshBuilder().box({0, 0, 0}, {1, 1, 1}).build(0)}), 0.3f), 12u);
    EXPECT_EQ(count(scene_of({make_icosphere(4, 0)}), 0.1f), 0u) << "smooth against the disc";
    EXPECT_GT(count(scene_of({make_icosphere(4, 0)}), 2), 1000u) << "not small against the sphere";
    const std::vector<vec2> chamfered = {{0.5f, 0}, {0.5f, 0.499f}, {0.499f, 0.5f}, {0, 0.5f}};
    EXPECT_GE(count(scene_of({MeshBuilder().lathe(chamfered, 4, 0).build(0)}), 0.1f), 8u) << "no bend of 60 degrees";

    // Three squares in a row, two of them instances of the first, one mirrored: eight edges around them.
    Scene row = scene_of({floor_mesh({0, 0}, {1, 1})});
    Instance beside, mirrored;
    beside.identity = mirrored.identity = false;
    beside.to_world = mat4x3(vec3(1, 0, 0), kUp, vec3(0, 0, 1), vec3(1, 0, 0));
    mirrored.to_world = mat4x3(vec3(-1, 0, 0), kUp, vec3(0, 0, 1), vec3(0, 0, 0));
    mirrored.flips_orientation = true;
    row.instances.push_back(beside);
    row.instances.push_back(mirrored);
    finish_scene(row);
    EXPECT_EQ(count(row, 0.2f), 8u);
    EXPECT_EQ(count(Scene{}, 1), 0u);
}

/// By the ends, and by the foot of the perpendicular where that is between them.
double distance_m(const vec3& p, const SurfaceEdge& e) {
    const dvec3 a(e.a), b(e.b), q(p);
    const double to_ends = std::min(glm::distance(q, a), glm::distance(q, b)), length = glm::distance(a, b);
    const bool between = glm::dot(q - a, b - a) > 0 && glm::dot(q - b, a - b) > 0;
    return between ? glm::length(glm::cross(q - a, b - a)) / length : to_ends;
}

TEST(EdgeTree, HasThoseNearAndIsTheSameForAnyNumberOfThreads) {
    RandomStream random(4, RandomDomain::Test, 0, 0);
    const auto point = [&] { return vec3(random.next(), random.next(), random.next()) * 2.0f - 1.0f; };
    for (const int count : {1, 4, 5, 600}) {
        std::vector<SurfaceEdge> edges;
        for (int i = 0; i < count; ++i) {
            const vec3 a = point();
            edges.push_back({a, a + std::pow(0.001f, random.next()) * point(), i % 3 == 2 ? 0.03f : 0});
        }
        const EdgeTree tree(edges);
        tbb::task_arena one(1);
        const EdgeTree single = one.execute([&] { return EdgeTree(edges); });
        EXPECT_EQ(tree.device_words(), single.device_words());
        size_t near = 0, spared = 0;
        for (int i = 0; i < 3000; ++i) {
            const vec3 p = 1.2f * point();
            const float radius_m = 0.1f * std::pow(0.02f, random.next());
            double least_m = 10;  // of those that a disc of that radius minds
            for (const SurfaceEdge& e : edges) {
                const double of_edge_m = distance_m(p, e);
                if (e.harmless_m < radius_m)
                    least_m = std::min(least_m, of_edge_m);
                else
                    spared += of_edge_m < double{radius_m};
            }
            if (std::fabs(least_m - double{radius_m}) < 1e-5) continue;  // rounding decides
            EXPECT_EQ(tree.has_edges(p, radius_m), least_m < double{radius_m}) << count;
            near += least_m < double{radius_m};
        }
        if (count < 600) continue;
        EXPECT_GT(near, 40u);
        EXPECT_GT(spared, 0u);
    }
    EXPECT_FALSE(EdgeTree({}).has_edges(vec3(0), 1));
}

}  // namespace
}  // namespace photond::disc_coverage_test
