// The share of a kernel that lies on a surface, against brute force: points of the disc spread as the kernel is, each
// looked up on the triangles themselves. And the tree of edges against a loop over all.

#include "renderer/photons/surface_boundary.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <set>

#include "renderer/photons/boundary_tree.h"
#include "renderer/scene/intersector.h"
#include "renderer/transport/sampling.h"
#include "tests/support/rays.h"
#include "tests/support/statistics.h"
#include "tests/support/surface_scenes.h"

namespace photond::surface_boundary_test {
namespace {

using test::add_floor;
using test::floor_mesh;
using test::kKernels;
using test::kUp;
using test::name_of;
using test::scene_of;

SurfaceBoundary boundary_of(const Scene& scene, float radius_m) {
    return SurfaceBoundary(scene, *test::intersector_of(scene), radius_m);
}

Scene unit_floor() { return scene_of({floor_mesh({0, 0}, {1, 1})}); }

/// Midpoints of `count` shares of equal mass.
std::vector<float> radii_of_equal_mass(const Kernel& kernel, int count) {
    std::vector<float> radii;
    for (int i = 0; i < count; ++i) {
        float low = 0, high = 1;
        for (int step = 0; step < 30; ++step) {
            const float q = 0.5f * (low + high);
            (kernel.mass_within(q) < (static_cast<float>(i) + 0.5f) / static_cast<float>(count) ? low : high) = q;
        }
        radii.push_back(0.5f * (low + high));
    }
    return radii;
}

/// Whether the line through q along `normal` meets, within the thickness, a triangle that makes at most 60 degrees.
bool lies_on_surface(const std::vector<TriangleCorners>& triangles, const vec3& q, const vec3& normal,
                     float thickness_m) {
    for (const TriangleCorners& t : triangles) {
        const vec3 e1 = t.p[1] - t.p[0], e2 = t.p[2] - t.p[0], p = glm::cross(normal, e2), from = q - t.p[0];
        const float determinant = glm::dot(e1, p);
        const float u = glm::dot(from, p) / determinant;
        const vec3 side = glm::cross(from, e1);
        const float v = glm::dot(normal, side) / determinant;
        if (u >= 0 && v >= 0 && u + v <= 1 && std::fabs(glm::dot(e2, side) / determinant) <= thickness_m) return true;
    }
    return false;
}

struct Disc {
    vec3 p;
    vec3 normal;
    float radius_m;
    float thickness_m;
};

double brute_mass(const Scene& scene, const Kernel& kernel, const Disc& disc) {
    constexpr int kRadii = 250, kAngles = 503;
    std::vector<TriangleCorners> triangles;
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        for (uint32_t j = 0; j < scene.meshes[scene.instances[i].mesh].triangles.size(); ++j) {
            const TriangleCorners t = world_triangle(scene, i, j);
            const vec3 n = glm::normalize(glm::cross(t.p[1] - t.p[0], t.p[2] - t.p[0]));
            if (std::fabs(glm::dot(n, disc.normal)) >= 0.5f) triangles.push_back(t);
        }
    }
    const Frame frame(disc.normal);
    int inside = 0, turn = 0;
    for (const float q : radii_of_equal_mass(kernel, kRadii)) {
        turn += 191;  // rings turned against each other, so that no edge runs along the points
        for (int i = 0; i < kAngles; ++i) {
            const float angle = 2 * kPi * (static_cast<float>(i) + static_cast<float>(turn % 250) / 250) / kAngles;
            const vec3 at = q * disc.radius_m * (std::cos(angle) * frame.tangent + std::sin(angle) * frame.bitangent);
            inside += lies_on_surface(triangles, disc.p + at, disc.normal, disc.thickness_m);
        }
    }
    return static_cast<double>(inside) / (double{kRadii} * kAngles);
}

/// The clamp is not what is tested here.
double clamped(double mass) { return std::max<double>(mass, SurfaceBoundary::kLeastMass); }

void expect_brute_force(const Scene& scene, const SurfaceBoundary& boundary, const Disc& disc) {
    for (const Kernel& kernel : kKernels) {
        EXPECT_NEAR(boundary.mass_on_surface(kernel, disc.p, disc.normal, disc.radius_m, disc.thickness_m),
                    clamped(brute_mass(scene, kernel, disc)), 1e-3)
            << name_of(kernel) << " at " << disc.p.x << " " << disc.p.y << " " << disc.p.z;
    }
}

/// The kernel's mass beyond a line at distance q (of the radius), by a sum over a fine division of the angle.
double mass_beyond_line(const Kernel& kernel, double q) {
    constexpr int kSteps = 20000;
    const double last = std::acos(q);
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
        sum += 1 - double{kernel.mass_within(static_cast<float>(q / std::cos(last * (i + 0.5) / kSteps)))};
    }
    return sum * last / kSteps / 3.14159265358979;
}

TEST(SurfaceBoundary, StraightEdgeToAFewMillionths) {
    const Scene scene = unit_floor();
    const SurfaceBoundary boundary = boundary_of(scene, 0.2f);
    EXPECT_EQ(boundary.edges(), 4u);
    for (const Kernel& kernel : kKernels) {
        for (const float q : {0.001f, 0.01f, 0.05f, 0.1f, 0.3f, 0.5f, 0.7f, 0.9f, 0.99f}) {
            const float mass = boundary.mass_on_surface(kernel, vec3(0.2f * q, 0, 0.5f), kUp, 0.2f, 0.05f);
            EXPECT_NEAR(mass, 1 - mass_beyond_line(kernel, q), 3e-5) << name_of(kernel) << " at " << q;
        }
        EXPECT_EQ(boundary.mass_on_surface(kernel, vec3(0.5f, 0, 0.5f), kUp, 0.2f, 0.05f), 1);
        EXPECT_EQ(boundary.mass_on_surface(kernel, vec3(0.201f, 0, 0.5f), kUp, 0.2f, 0.05f), 1);
    }
}

TEST(SurfaceBoundary, SquareAtItsCornerItsEdgeAndItsCentre) {
    const Scene scene = unit_floor();
    const SurfaceBoundary boundary = boundary_of(scene, 0.8f);
    for (const float radius : {0.1f, 0.3f, 0.8f}) {  // the last holds the whole square
        for (const vec2 at :
             {vec2(0.001f, 0.001f), vec2(0.05f, 0.02f), vec2(0.5f, 0.04f), vec2(0.5f, 0.5f), vec2(0.93f, 0.81f)}) {
            expect_brute_force(scene, boundary, {vec3(at.x, 0, at.y), kUp, radius, radius / 4});
        }
    }
    EXPECT_NEAR(boundary.mass_on_surface(kKernels[0], vec3(1e-4f, 0, 1e-4f), kUp, 0.3f, 0.1f), 0.25, 1e-3);
}

TEST(SurfaceBoundary, BothSidesOfASheetAndTwoCoincidentSheetsAreOneSurface) {
    Mesh both = floor_mesh({0, 0}, {1, 1});
    for (const uvec3 t : std::vector<uvec3>(both.triangles)) both.triangles.push_back({t.x, t.z, t.y});
    const Scene single = unit_floor(), twice = scene_of({floor_mesh({0, 0}, {1, 1}), floor_mesh({0, 0}, {1, 1})}),
                two_sided = scene_of({both});
    for (const Scene* scene : {&single, &twice, &two_sided}) {
        const SurfaceBoundary boundary = boundary_of(*scene, 0.3f);
        EXPECT_EQ(boundary.edges(), 4u);
        for (const vec3& normal : {kUp, -kUp}) {
            expect_brute_force(single, boundary, {vec3(0.1f, 0, 0.07f), normal, 0.3f, 0.075f});
        }
    }
}

TEST(SurfaceBoundary, RandomHolesInAPlaneOfSlantedCells) {
    // Cells of uneven shape, a third of them missing: holes, strips and islands narrower than the disc.
    constexpr int kCells = 9;
    RandomStream random(1, RandomDomain::Test, 0, 0);
    std::vector<vec3> grid;
    const glm::mat3 tilt(glm::rotate(mat4(1), 0.7f, glm::normalize(vec3(1, 2, -1))));
    for (int y = 0; y <= kCells; ++y) {
        for (int x = 0; x <= kCells; ++x) {
            const vec2 moved = vec2(static_cast<float>(x), static_cast<float>(y)) + 0.6f * (random.next_2d() - 0.5f);
            grid.push_back(tilt * vec3(moved.x, 0, -moved.y) * (1.0f / kCells));
        }
    }
    MeshBuilder builder;
    std::vector<vec3> on_surface;
    for (int y = 0; y < kCells; ++y) {
        for (int x = 0; x < kCells; ++x) {
            if (random.next() < 0.33f) continue;
            const auto corner = [&](int i, int j) { return grid[static_cast<size_t>((y + j) * (kCells + 1) + x + i)]; };
            builder.quad(corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
            on_surface.push_back(glm::mix(corner(0, 0), corner(1, 1), 0.2f + 0.6f * random.next()));
        }
    }
    const Scene scene = scene_of({builder.build(0)});
    const SurfaceBoundary boundary = boundary_of(scene, 0.25f);
    for (size_t i = 0; i < on_surface.size(); i += 7) {
        const float radius = 0.03f + 0.22f * random.next();
        expect_brute_force(scene, boundary, {on_surface[i], tilt * kUp, radius, 0.05f});
    }
}

TEST(SurfaceBoundary, NarrowStripAndSmallTriangle) {
    const Scene strip = scene_of({floor_mesh({-1, -0.05f}, {1, 0.05f})});
    const SurfaceBoundary of_strip = boundary_of(strip, 0.3f);
    for (const float z : {0.0f, 0.02f, 0.049f}) expect_brute_force(strip, of_strip, {{0, 0, z}, kUp, 0.3f, 0.1f});

    const Scene triangle = scene_of({MeshBuilder().triangle({0, 0, 0}, {0.2f, 0, 0.05f}, {0.15f, 0, -0.15f}).build(0)});
    const SurfaceBoundary of_triangle = boundary_of(triangle, 0.5f);
    for (const float radius : {0.1f, 0.2f, 0.5f}) {
        expect_brute_force(triangle, of_triangle, {{0.12f, 0, -0.03f}, kUp, radius, 0.1f});
    }
    EXPECT_EQ(of_triangle.mass_on_surface(kKernels[0], {0.12f, 0, -0.03f}, kUp, 0.5f, 0.1f),
              SurfaceBoundary::kLeastMass);
}

TEST(SurfaceBoundary, EdgesThatMeetInTJunctionsCancel) {
    // An L of three rectangles: one long side against two short ones, and against half of a longer one.
    const Scene scene = scene_of(
        {floor_mesh({0, 0}, {1, 0.31f}), floor_mesh({0, 0.31f}, {0.37f, 1}), floor_mesh({0.37f, 0.31f}, {0.63f, 1})});
    const SurfaceBoundary boundary = boundary_of(scene, 0.25f);
    for (const vec2 at : {vec2(0.37f, 0.32f), vec2(0.3f, 0.3f), vec2(0.62f, 0.33f), vec2(0.7f, 0.29f),
                          vec2(0.02f, 0.31f), vec2(0.5f, 0.9f)}) {
        expect_brute_force(scene, boundary, {vec3(at.x, 0, at.y), kUp, 0.25f, 0.06f});
    }
    // On the seams, to rounding and beyond, nothing is lost that is not.
    for (const Kernel& kernel : kKernels) {
        for (const float off : {-1e-4f, -1e-6f, -1e-8f, 0.0f, 1e-8f, 1e-6f, 1e-4f}) {
            EXPECT_NEAR(boundary.mass_on_surface(kernel, {0.3f, 0, 0.31f + off}, kUp, 0.25f, 0.06f), 1, 1e-4) << off;
            EXPECT_NEAR(boundary.mass_on_surface(kernel, {0.37f + off, 0, 0.6f}, kUp, 0.2f, 0.06f), 1, 1e-4) << off;
        }
    }
}

TEST(SurfaceBoundary, PiecesOfAWallWeldAcrossMeshesAndInstances) {
    Scene scene = scene_of({floor_mesh({0, 0}, {1, 1})});
    Instance beside, mirrored;
    beside.identity = mirrored.identity = false;
    beside.to_world = mat4x3(vec3(1, 0, 0), kUp, vec3(0, 0, 1), vec3(1, 0, 0));
    mirrored.to_world = mat4x3(vec3(-1, 0, 0), kUp, vec3(0, 0, 1), vec3(0, 0, 0));
    mirrored.flips_orientation = true;
    scene.instances.push_back(beside);
    scene.instances.push_back(mirrored);
    finish_scene(scene);
    const SurfaceBoundary boundary = boundary_of(scene, 0.2f);
    EXPECT_EQ(boundary.edges(), 8u);  // around three squares in a row
    for (const float x : {-0.01f, 0.0f, 0.02f, 0.99f, 1.0f}) {
        EXPECT_EQ(boundary.mass_on_surface(kKernels[0], {x, 0, 0.5f}, kUp, 0.2f, 0.05f), 1);
    }
}

TEST(SurfaceBoundary, WallsOfABoxDoNotCountForItsFloor) {
    const Scene scene = scene_of({MeshBuilder().box({0, 0, 0}, {1, 1, 1}).build(0)});
    const SurfaceBoundary boundary = boundary_of(scene, 0.3f);
    const Scene bottom = unit_floor();
    for (const vec3& normal : {kUp, -kUp}) {  // from inside and from below
        expect_brute_force(bottom, boundary, {{0.1f, 0, 0.5f}, normal, 0.3f, 0.075f});
        expect_brute_force(bottom, boundary, {{0.1f, 0, 0.95f}, normal, 0.3f, 0.075f});
    }
}

TEST(SurfaceBoundary, WallThatStandsOnAFloorEndsThereAndTheFloorDoesNot) {
    MeshBuilder builder;
    add_floor(builder, {-1, -1}, {0, 1});
    add_floor(builder, {0, -1}, {1, 1});
    builder.quad({0, 0, 1}, {0, 0, -1}, {0, 1, -1}, {0, 1, 1});  // on the seam
    const Scene scene = scene_of({builder.build(0)});
    const SurfaceBoundary boundary = boundary_of(scene, 0.3f);
    for (const Kernel& kernel : kKernels) {
        EXPECT_EQ(boundary.mass_on_surface(kernel, {0.05f, 0, 0.1f}, kUp, 0.3f, 0.075f), 1);
        EXPECT_EQ(boundary.mass_on_surface(kernel, {-0.05f, 0, 0.1f}, kUp, 0.3f, 0.075f), 1);
        for (const float side : {-1.0f, 1.0f}) {
            EXPECT_NEAR(boundary.mass_on_surface(kernel, {0, 0.06f, 0}, {side, 0, 0}, 0.3f, 0.075f),
                        1 - mass_beyond_line(kernel, 0.2), 1e-4);
        }
    }
}

TEST(SurfaceBoundary, SmoothSurfacesHaveNoEdges) {
    const Scene scene = scene_of({make_icosphere(4, 0)});
    EXPECT_EQ(boundary_of(scene, 0.1f).edges(), 0u);
    // Bends are kept when the disc is not small against the sphere; they lie beyond its thickness.
    const SurfaceBoundary wide = boundary_of(scene, 0.5f);
    for (const vec3& p : scene.meshes[0].positions) {
        EXPECT_EQ(wide.mass_on_surface(kKernels[0], p, glm::normalize(p), 0.5f, 0.125f), 1);
    }
}

TEST(SurfaceBoundary, ChamferedEdgesEndASurface) {
    // A block whose upper edges are cut at 45 degrees, a millimetre wide: no edge bends by 60 degrees, the surface
    // does.
    const std::vector<vec2> profile = {{0.5f, 0}, {0.5f, 0.499f}, {0.499f, 0.5f}, {0, 0.5f}};
    const Scene scene = scene_of({MeshBuilder().lathe(profile, 4, 0).build(0)});
    const SurfaceBoundary boundary = boundary_of(scene, 0.1f);
    const vec3 corner = scene.meshes[0].positions[0], next(-corner.z, 0, corner.x);
    const vec3 to_side = 0.5f * (vec3(corner.x, 0, corner.z) + next);
    for (const Kernel& kernel : kKernels) {
        const vec3 p = to_side * (1 - 0.03f / glm::length(to_side)) + 0.5f * kUp;
        EXPECT_NEAR(boundary.mass_on_surface(kernel, p, kUp, 0.1f, 0.025f), 1 - mass_beyond_line(kernel, 0.3), 1e-3);
    }
}

TEST(SurfaceBoundary, FrontAndBackOfAThinBodyAreNotAddedUp) {
    const Scene scene = scene_of({MeshBuilder().box({0, 0, 0}, {1, 0.01f, 1}).build(0)});
    const SurfaceBoundary boundary = boundary_of(scene, 0.2f);
    for (const Kernel& kernel : kKernels) {
        for (const float y : {0.0f, 0.01f}) {
            for (const vec3& normal : {kUp, -kUp}) {
                EXPECT_NEAR(boundary.mass_on_surface(kernel, {0.05f, y, 0.5f}, normal, 0.2f, 0.05f),
                            1 - mass_beyond_line(kernel, 0.25), 1e-4);
            }
        }
    }
}

TEST(SurfaceBoundary, RimOfACarpetDoesNotCountWhereTheFloorIsWithinTheDisc) {
    // Half of the carpet hangs over the end of the floor.
    const Scene scene = scene_of({floor_mesh({0, 0}, {2, 2}), floor_mesh({0.5f, 0.5f}, {1.5f, 3}, 0.01f)});
    const SurfaceBoundary boundary = boundary_of(scene, 0.2f);
    for (const Kernel& kernel : kKernels) {
        const auto mass = [&](vec3 p, float thickness_m) {
            return boundary.mass_on_surface(kernel, p, kUp, 0.2f, thickness_m);
        };
        const double cut = 1 - mass_beyond_line(kernel, 0.25);
        EXPECT_EQ(mass({0.55f, 0.01f, 1}, 0.05f), 1);             // on the carpet
        EXPECT_EQ(mass({0.45f, 0, 1}, 0.05f), 1);                 // beside it
        EXPECT_NEAR(mass({0.55f, 0.01f, 1}, 0.008f), cut, 1e-4);  // the floor is too far below
        EXPECT_EQ(mass({0.45f, 0, 1}, 0.008f), 1);
        EXPECT_NEAR(mass({0.55f, 0.01f, 2.5f}, 0.05f), cut, 1e-4);  // no floor below
    }
}

TEST(SurfaceBoundary, DivisionByTheMassUnbiasesTheEstimateAtAnyPlace) {
    // Photons uniform on a square with a square hole: the mean of K / mass is the density, 1 / area.
    constexpr double kFalseAlarm = 1e-6;
    constexpr double kMustDetect = 0.03;
    constexpr float kRadius = 0.3f;
    const std::vector<std::pair<vec2, vec2>> rectangles = {
        {{0, 0}, {1, 0.4f}}, {{0, 0.6f}, {1, 1}}, {{0, 0.4f}, {0.3f, 0.6f}}, {{0.5f, 0.4f}, {1, 0.6f}}};
    MeshBuilder builder;
    for (const auto& [min, max] : rectangles) add_floor(builder, min, max);
    const Scene scene = scene_of({builder.build(0)});
    const SurfaceBoundary boundary = boundary_of(scene, kRadius);
    const std::vector<vec2> places = {{0.01f, 0.01f}, {0.15f, 0.5f}, {0.29f, 0.39f},
                                      {0.55f, 0.5f},  {0.9f, 0.02f}, {0.4f, 0.38f}};
    std::vector<test::RunningMean> means(places.size() * kKernels.size());
    RandomStream random(1, RandomDomain::Test, 0, 0);
    for (int photon = 0; photon < 800'000;) {
        const vec2 y = random.next_2d();
        if (y.x > 0.3f && y.x < 0.5f && y.y > 0.4f && y.y < 0.6f) continue;
        ++photon;
        for (size_t i = 0; i < means.size(); ++i) {
            const vec2 to = y - places[i / kKernels.size()];
            const float q_sq = glm::dot(to, to) / sqr(kRadius);
            means[i].add(q_sq < 1 ? double{kKernels[i % kKernels.size()](q_sq)} / double{sqr(kRadius)} : 0.0);
        }
    }
    const double z = test::two_sided_z(test::share_of_false_alarm(kFalseAlarm, means.size()));
    for (size_t i = 0; i < means.size(); ++i) {
        const Kernel& kernel = kKernels[i % kKernels.size()];
        const vec2 at = places[i / kKernels.size()];
        const double mass = boundary.mass_on_surface(kernel, {at.x, 0, at.y}, kUp, kRadius, 0.1f);
        const double ratio = means[i].mean() / mass * 0.96, half_width = z * means[i].standard_error() / mass * 0.96;
        EXPECT_LE(std::abs(ratio - 1), half_width) << name_of(kernel) << " at " << at.x << " " << at.y;
        EXPECT_LE(half_width, kMustDetect) << "too noisy to notice a defect; raise the photon count";
        EXPECT_LT(mass, 0.97) << "a place at which nothing is cut off tests nothing";
    }
}

TEST(SurfaceBoundary, IsTheSameForAnyNumberOfThreads) {
    MeshBuilder builder;
    RandomStream random(2, RandomDomain::Test, 0, 0);
    const auto point = [&] { return vec3(random.next(), 0.1f * random.next(), random.next()); };
    for (int i = 0; i < 5000; ++i) {
        const vec3 at = point();
        builder.triangle(at, at + 0.05f * point(), at + 0.05f * point());
    }
    const Scene scene = scene_of({builder.build(0)});
    const SurfaceBoundary all = boundary_of(scene, 0.05f);
    tbb::task_arena one(1);
    const SurfaceBoundary single = one.execute([&] { return boundary_of(scene, 0.05f); });
    EXPECT_EQ(all.edges(), single.edges());
    EXPECT_EQ(all.bytes(), single.bytes());
    for (int i = 0; i < 2000; ++i) {
        const vec3 p = point();
        EXPECT_EQ(all.mass_on_surface(kKernels[0], p, kUp, 0.05f, 0.0125f),
                  single.mass_on_surface(kKernels[0], p, kUp, 0.05f, 0.0125f));
    }
}

TEST(SurfaceBoundary, TrianglesOfAnySizeAgainstTheDiscFarFromTheOrigin) {
    // Edges from a hundredth of the radius, in one cell, to a thousand radii, which run through many.
    RandomStream random(3, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 60; ++i) {
        const float size = 0.003f * std::pow(1e5f, random.next());
        const auto point = [&] {
            return vec3(100, -50, 20) + size * vec3(random.next(), random.next(), random.next());
        };
        const vec3 a = point(), b = point(), c = point();
        const vec3 across = glm::cross(b - a, c - a);
        if (glm::length(across) < 0.05f * size * size) continue;
        const Scene scene = scene_of({MeshBuilder().triangle(a, b, c).build(0)});
        const SurfaceBoundary boundary = boundary_of(scene, 0.3f);
        const vec2 u = 0.1f + 0.7f * sample_triangle(random.next_2d());  // off the edges by more than rounding
        const vec3 p = a + u.x * (b - a) + u.y * (c - a);
        const Disc disc = {p, glm::normalize(across), 0.3f, 0.07f};
        EXPECT_NEAR(boundary.mass_on_surface(kKernels[3], p, disc.normal, 0.3f, 0.07f),
                    clamped(brute_mass(scene, kKernels[3], disc)), 2e-3);
    }
    EXPECT_EQ(boundary_of(Scene{}, 1).mass_on_surface(kKernels[0], vec3(0), kUp, 1, 0.25f), 1);
}

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

TEST(BoundaryEdges, AskForAFewRaysEachHoweverManyLieAbout) {
    const Scene scene = test::heap_on_a_floor();
    const auto intersector = test::intersector_of(scene);
    const CountingIntersector counting(*intersector);
    const std::vector<BoundaryEdge> edges = find_boundary_edges(scene, counting, 0.16f);
    // Those of the chips are shorter than the radius, one probe each; the floor's four have 25.
    EXPECT_EQ(edges.size(), 24'000u + 4);
    EXPECT_GE(counting.rays, 2 * 24'000u);
    EXPECT_LE(counting.rays, 16 * 24'100u);
}

TEST(BoundaryEdges, GoOnAtTheNearestSurfaceThatIsNotSteep) {
    // Beyond the rim of the sheet at y = 0: a steep surface 1 cm above, which does not count, and others beyond it.
    MeshBuilder others;
    others.quad({0.95f, 0.005f, 1}, {1.15f, 0.805f, 1}, {1.15f, 0.805f, 0}, {0.95f, 0.005f, 0});
    for (const float height : {0.37f, 0.39f, -0.38f}) add_floor(others, {0.5f, -1}, {2, 2}, height);
    const Scene scene = scene_of({floor_mesh({0, 0}, {1, 1}), others.build(0)});
    const auto continues_at_m = [&](float radius_m) {
        for (const BoundaryEdge& e : find_boundary_edges(scene, *test::intersector_of(scene), radius_m))
            if (e.a.x == 1 && e.b.x == 1 && e.a.y == 0 && e.b.y == 0) return e.continues_at_m;
        return -1.0f;
    };
    EXPECT_NEAR(continues_at_m(0.4f), 0.37f, 1e-5f);
    EXPECT_EQ(continues_at_m(0.35f), kInfinity) << "beyond the radius";
}

TEST(BoundaryTree, VisitsEveryEdgeThatALoopOverAllFinds) {
    RandomStream random(4, RandomDomain::Test, 0, 0);
    const auto point = [&] { return vec3(random.next(), random.next(), random.next()) * 2.0f - 1.0f; };
    const auto bounds_surface = [](float c, float other) {
        return (c >= kSameSurface) != (other >= kSameSurface) || (c <= -kSameSurface) != (other <= -kSameSurface);
    };
    for (const size_t count : {0, 1, 7, 8, 9, 64, 65, 513, 6000}) {
        std::vector<BoundaryEdge> edges;
        for (size_t i = 0; i < count; ++i) {
            // Half-edges and bends of 0.1 at most.
            const vec3 a = point(), normal = glm::normalize(point());
            const vec3 other = i % 4 == 0 ? vec3(0) : glm::normalize(normal + 0.05f * point());
            edges.push_back({a, a + std::pow(0.001f, random.next()) * point(), normal, other, kInfinity});
        }
        const BoundaryTree tree(edges, 0.1f);
        EXPECT_EQ(tree.size(), count);
        size_t met = 0, visited_edges = 0;
        for (int i = 0; i < 300; ++i) {
            const vec3 p = 1.2f * point(), normal = glm::normalize(point());
            const float radius = 0.1f * random.next(), thickness = 0.5f * radius;
            std::multiset<float> visited;  // starts tell edges apart
            tree.visit_blocks(p, normal, radius, thickness, BoundaryTree::Limit::None, [&](const EdgeBlock& block) {
                for (const float x : block.a.axis[0])
                    if (x != 0) visited.insert(x);  // 0: no edge
            });
            visited_edges += visited.size();
            for (const BoundaryEdge& e : edges) {
                if (!bounds_surface(glm::dot(e.normal, normal), glm::dot(e.other_normal, normal))) continue;
                bool in_reach = false;
                for (int step = 0; step <= 50 && !in_reach; ++step) {
                    const vec3 q = glm::mix(e.a, e.b, static_cast<float>(step) / 50) - p;
                    in_reach = glm::dot(q, q) < sqr(radius) && std::fabs(glm::dot(q, normal)) < thickness;
                }
                if (!in_reach) continue;
                ++met;
                EXPECT_EQ(visited.count(e.a.x), 1u);
                EXPECT_TRUE(tree.may_have_edges(p));
            }
        }
        if (count == 6000) {
            EXPECT_GT(met, 30u);
            EXPECT_LT(visited_edges, 120'000u) << "the tree leaves hardly anything out";  // of 1.8 million
        }
    }
}

}  // namespace
}  // namespace photond::surface_boundary_test
