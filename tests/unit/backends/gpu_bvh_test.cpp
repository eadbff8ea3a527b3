// The device's ray structure: the host's traversal of it against Embree, the device's against the host's.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "protocol/error.h"
#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/backends/gpu/bvh.h"
#include "renderer/backends/gpu/device_scene.h"
#include "renderer/backends/gpu/scene_bindings.h"
#include "renderer/core/rng.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/scene.h"
#include "tests/support/gpu_twin.h"

namespace photond::gpu_bvh_test {
namespace {

using namespace test;

/// As in bvh.comp.
struct Answer {
    Hit hit;
    uint32_t occluded;
};
static_assert(sizeof(Ray) == 28 && sizeof(Answer) == 24);

vec3 random_point(RandomStream& random) {
    const float x = random.next(), y = random.next();
    return {x, y, random.next()};
}

/// Random triangles in the unit cube; `spread` is their size.
Mesh triangle_soup(uint32_t count, float spread, uint64_t seed) {
    RandomStream random(seed, RandomDomain::Test, 0, 0);
    Mesh mesh;
    for (uint32_t i = 0; i < count; ++i) {
        const vec3 centre = random_point(random);
        for (int c = 0; c < 3; ++c) mesh.positions.push_back(centre + spread * (random_point(random) - 0.5f));
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh;
}

/// From within and around the box; half of them short.
std::vector<Ray> random_rays(const Bounds3& box, size_t count, uint64_t seed) {
    RandomStream random(seed, RandomDomain::Test, 1, 0);
    const vec3 size = box.empty() ? vec3(1) : box.diagonal();
    std::vector<Ray> rays;
    while (rays.size() < count) {
        const vec3 d = random_point(random) - 0.5f;
        if (glm::length(d) < 0.01f) continue;
        const vec3 origin = (box.empty() ? vec3(0) : box.min) + size * (1.5f * random_point(random) - 0.25f);
        rays.push_back(
            {origin, glm::normalize(d), random.next() < 0.5f ? kInfinity : random.next() * glm::length(size)});
    }
    return rays;
}

Scene finished(std::vector<Mesh> meshes, std::vector<Instance> instances, std::vector<Material> materials = {{}}) {
    Scene scene;
    scene.meshes = std::move(meshes);
    scene.instances = std::move(instances);
    scene.materials = std::move(materials);
    finish_scene(scene);
    return scene;
}

Instance placed(uint32_t mesh, const mat3& linear, const vec3& translation) {
    Instance instance;
    instance.mesh = mesh;
    instance.identity = false;
    instance.to_world = mat4x3(linear[0], linear[1], linear[2], translation);
    instance.normal_to_world = glm::transpose(glm::inverse(linear));
    instance.flips_orientation = glm::determinant(linear) < 0;
    return instance;
}

Scene instanced_scene() {
    const mat3 turn(vec3(0, 0.5f, 0), vec3(-0.5f, 0, 0), vec3(0, 0, 0.5f)),
        mirror(vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)), large(vec3(30, 0, 0), vec3(3, 9, 0), vec3(0, 0, 12));
    return finished({triangle_soup(200, 0.3f, 1), triangle_soup(300, 0.2f, 2)},
                    {placed(1, turn, vec3(0.5f, 0, 0)),
                     {},
                     placed(1, mirror, vec3(1, 0.2f, 0)),
                     placed(1, turn, vec3(0.6f, 0.1f, 0.2f)),
                     placed(1, large, vec3(-5, 2, -5))});
}

std::vector<Answer> device_answers(const gpu::BvhData& bvh, const std::vector<Ray>& rays) {
    const PartOfScene part({{BVH_NODES_BINDING, std::as_bytes(std::span(bvh.nodes))},
                            {BVH_TRIANGLES_BINDING, std::as_bytes(std::span(bvh.triangles))}});
    const Twin twin("tests/gpu/bvh.comp", &part.set(),
                    {gpu::specialize(1, false), gpu::specialize(BVH_TWO_LEVELS_ID, bvh.two_levels)});
    return twin.run<Answer>(rays.size(), {{"rays", rays}});
}

/// The same hit but for rounding: another triangle only where both lie equally far, as at an edge or where faces
/// coincide.
bool same(const Hit& a, const Hit& b, float distance) {
    if (a.valid() != b.valid()) return false;
    if (!a.valid()) return true;
    if (std::abs(a.t - b.t) > distance) return false;
    return a.instance != b.instance || a.triangle != b.triangle ||
           (std::abs(a.u - b.u) < 1e-3f && std::abs(a.v - b.v) < 1e-3f);
}

struct Differences {
    size_t embree = 0, device = 0, occlusion = 0, hits = 0;
};

Differences differences(const Scene& scene, const std::vector<Ray>& rays,
                        uint64_t most_copied_triangles = gpu::kMostCopiedTriangles) {
    const gpu::BvhData bvh = gpu::build_bvh(scene, most_copied_triangles);
    MemoryBudget budget;
    Stats stats;
    const std::unique_ptr<Intersector> embree = make_embree_intersector(scene, budget, stats);
    const std::vector<Answer> answers = device_answers(bvh, rays);
    const float tolerance = 1e-5f * (scene.bounds.empty() ? 1 : glm::length(scene.bounds.diagonal()));
    Differences found;
    for (size_t i = 0; i < rays.size(); ++i) {
        const Hit host = gpu::closest_hit(bvh, scene, rays[i]);
        found.hits += host.valid();
        found.embree += !same(host, embree->closest_hit(rays[i]), tolerance);
        found.device += !same(host, answers[i].hit, tolerance);
        found.occlusion +=
            gpu::occluded(bvh, scene, rays[i]) != host.valid() || (answers[i].occluded != 0) != answers[i].hit.valid();
    }
    return found;
}

TEST(GpuBvh, AgreesWithEmbreeInBuiltInScenes) {
    for (const std::string_view name : {"cornell-box", "cornell-box-glass", "interior", "caustic-ring"}) {
        SCOPED_TRACE(name);
        const Scene scene = make_builtin_scene(name);
        const std::vector<Ray> rays = random_rays(scene.bounds, 4001, 3);
        const Differences found = differences(scene, rays);
        EXPECT_LE(found.embree, 2);
        EXPECT_LE(found.device, 2);
        EXPECT_EQ(found.occlusion, 0);
        EXPECT_GT(found.hits, rays.size() / 10);
    }
}

TEST(GpuBvh, AgreesWithEmbreeInRandomTriangles) {
    for (const uint32_t count : {1u, 2u, 12u, 100u, 20000u}) {
        SCOPED_TRACE(count);
        const Scene scene = finished({triangle_soup(count, count > 1000 ? 0.05f : 0.7f, count)}, {{}});
        const std::vector<Ray> rays = random_rays(scene.bounds, 4001, 5);
        const Differences found = differences(scene, rays);
        EXPECT_LE(found.embree, 2);
        EXPECT_LE(found.device, 2);
        EXPECT_EQ(found.occlusion, 0);
        EXPECT_GT(found.hits, 20);
    }
}

TEST(GpuBvh, PlacesInstancesMirroredOnesIncluded) {
    const Scene scene = instanced_scene();
    const std::vector<Ray> rays = random_rays({vec3(-1), vec3(2)}, 8001, 7);
    for (const uint64_t most_copied_triangles : {uint64_t{0}, gpu::kMostCopiedTriangles}) {
        SCOPED_TRACE(most_copied_triangles);
        EXPECT_EQ(gpu::build_bvh(scene, most_copied_triangles).two_levels, most_copied_triangles == 0);
        const Differences found = differences(scene, rays, most_copied_triangles);
        EXPECT_LE(found.embree, 4);
        EXPECT_LE(found.device, 4);
        EXPECT_EQ(found.occlusion, 0);
        EXPECT_GT(found.hits, rays.size() / 10);
    }
}

TEST(GpuBvh, AnswersRaysAlongAxesAndOfAnyLength) {
    // A grid of triangles in planes across the axes, at coordinates that boxes have too; rays along them and, with one
    // component of 0, within planes across them. What grazes an edge or a plane may go either way: rays start off
    // those.
    Mesh mesh;
    RandomStream random(13, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 300; ++i) {
        const int axis = i % 3;
        const vec3 corner = glm::floor(8.0f * random_point(random));
        vec3 along(0), across(0);
        along[(axis + 1) % 3] = 1, across[(axis + 2) % 3] = 1;
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), {corner, corner + along, corner + across});
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    const Scene scene = finished({mesh}, {{}});
    std::vector<Ray> rays;
    for (int i = 0; i < 3000; ++i) {
        vec3 direction(0);
        direction[i % 3] = random.next() < 0.5f ? -1.0f : 1.0f;
        if (i % 2) direction[(i + 1) % 3] = 2 * random.next() - 1;
        direction *= std::exp2(std::floor(40 * random.next()) - 20);
        rays.push_back({10.0f * random_point(random) - 1.0f, direction});
    }
    const gpu::BvhData bvh = gpu::build_bvh(scene);
    MemoryBudget budget;
    Stats stats;
    const std::unique_ptr<Intersector> embree = make_embree_intersector(scene, budget, stats);
    const std::vector<Answer> answers = device_answers(bvh, rays);
    size_t different = 0, hits = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
        const Hit host = gpu::closest_hit(bvh, scene, rays[i]);
        const float tolerance = 1e-4f / glm::length(rays[i].direction);
        different += !same(host, embree->closest_hit(rays[i]), tolerance) + !same(host, answers[i].hit, tolerance) +
                         (answers[i].occluded != 0) !=
                     host.valid();
        hits += host.valid();
    }
    EXPECT_LE(different, 6);
    EXPECT_GT(hits, rays.size() / 10);
}

/// Each a tenth larger than the one before and farther from the origin.
Mesh growing_triangles(float first_size, uint32_t count) {
    Mesh mesh;
    for (uint32_t i = 0; i < count; ++i) {
        const float x = first_size * std::pow(1.1f, float(i));
        for (const vec3& p : {vec3(x, 0, 0), vec3(1.1f * x, 0, x), vec3(1.1f * x, x, 0)}) mesh.positions.push_back(p);
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh;
}

TEST(GpuBvh, TakesCoincidentEmptyAndUnequalTriangles) {
    // What no plane divides: many copies of one triangle, many triangles without area in one point; and sizes over
    // twelve orders of magnitude, which make the tree deep.
    Mesh copies, points;
    for (uint32_t i = 0; i < 3000; ++i) {
        for (const vec3& p : {vec3(0, 0, 1), vec3(1, 0, 0.2f), vec3(0, 1, 0)}) copies.positions.push_back(p);
        for (int c = 0; c < 3; ++c) points.positions.push_back(vec3(0.5f));
        copies.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    points.triangles = copies.triangles;
    for (const Mesh& mesh : {copies, points, growing_triangles(1e-6f, 290)}) {
        const Scene scene = finished({mesh}, {{}});
        const std::vector<Ray> rays = random_rays(scene.bounds, 1001, 9);
        const Differences found = differences(scene, rays);
        EXPECT_LE(found.embree, 2);
        EXPECT_LE(found.device, 2);
        EXPECT_EQ(found.occlusion, 0);
        EXPECT_EQ(found.hits > 20, mesh.positions != points.positions);
    }
}

TEST(GpuBvh, RefusesATreeTooDeepForTheStack) {
    try {
        gpu::build_bvh(finished({growing_triangles(1e-30f, 850)}, {{}}));
        FAIL() << "was built";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::Unsupported);
        EXPECT_NE(std::string(error.what()).find(std::to_string(BVH_STACK)), std::string::npos) << error.what();
    }
}

TEST(GpuBvh, DoesNotTraceRaysWithoutLength) {
    const Scene scene = finished({triangle_soup(20, 1, 3)}, {{}});
    std::vector<Ray> rays = random_rays(scene.bounds, 100, 5);
    for (size_t i = 0; i < rays.size(); ++i) rays[i].t_max = i % 2 ? 0.0f : -1.0f;
    for (const Answer& answer : device_answers(gpu::build_bvh(scene), rays)) {
        EXPECT_FALSE(answer.hit.valid());
        EXPECT_EQ(answer.occluded, 0);
    }
}

TEST(GpuBvh, EmptyScenesAreNeverHit) {
    const Scene scene = finished({}, {});
    const gpu::BvhData bvh = gpu::build_bvh(scene);
    const std::vector<Ray> rays = random_rays({}, 100, 5);
    EXPECT_FALSE(gpu::closest_hit(bvh, scene, rays[0]).valid());
    for (const Answer& answer : device_answers(bvh, rays)) {
        EXPECT_FALSE(answer.hit.valid());
        EXPECT_EQ(answer.occluded, 0);
    }
}

TEST(GpuBvh, AClosedSurfaceDoesNotLeak) {
    // A box seen from within, its faces cut into many triangles, rays aimed at their edges and corners.
    Mesh box;
    constexpr int kCells = 12;
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2;
        for (int i = 0; i < kCells; ++i)
            for (int j = 0; j < kCells; ++j) {
                const auto corner = [&](int a, int b) {
                    vec3 p;  // the same bits wherever faces meet
                    p[axis] = face % 2 ? 1.7f : -1.3f;
                    p[(axis + 1) % 3] = glm::mix(-1.3f, 1.7f, float(a) / kCells);
                    p[(axis + 2) % 3] = glm::mix(-1.3f, 1.7f, float(b) / kCells);
                    return p;
                };
                const auto first = static_cast<uint32_t>(box.positions.size());
                box.positions.insert(box.positions.end(),
                                     {corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)});
                box.triangles.push_back({first, first + 1, first + 2});
                box.triangles.push_back({first, first + 2, first + 3});
            }
    }
    const Scene scene = finished({box}, {{}});
    RandomStream random(5, RandomDomain::Test, 0, 0);
    std::vector<Ray> rays;
    for (int i = 0; i < 100000; ++i) {
        const uvec3& t = box.triangles[random.next_bits() % box.triangles.size()];
        const uint32_t side = random.next_bits() % 3;
        const float along = i % 4 ? random.next() : 0.0f;
        const vec3 target = glm::mix(box.positions[t[int(side)]], box.positions[t[int((side + 1) % 3)]], along);
        const vec3 origin = vec3(0.2f) + 2.8f * (random_point(random) - 0.5f);
        rays.push_back({origin, glm::normalize(target - origin)});
    }
    size_t leaks = 0;
    for (const Answer& answer : device_answers(gpu::build_bvh(scene), rays))
        leaks += !answer.hit.valid() || answer.occluded == 0;
    EXPECT_EQ(leaks, 0);
}

/// A square of two triangles across the z axis at that height, and rays that go straight down through it.
Mesh square(float z, uint32_t material) {
    Mesh mesh;
    mesh.positions = {{0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z}};
    mesh.uv[0] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.material = material;
    return mesh;
}

TEST(GpuBvh, MeetsCoveringSurfacesAsTheProcessorDoes) {
    Texture texture;  // left half cut away
    texture.size = {2, 1};
    texture.texels = {{255, 255, 255, 0}, {255, 255, 255, 255}};
    texture.nearest = true;
    Material leaf, veil, floor;
    leaf.alpha_mode = AlphaMode::Mask;
    leaf.base_color_texture.texture = 0;
    veil.alpha_mode = AlphaMode::Blend;
    veil.alpha = 0.3f;
    Scene scene;
    scene.meshes = {square(2, 0), square(1, 1), square(0, 2)};
    scene.instances = {{}, placed(1, mat3(1.0f), vec3(0)), placed(1, mat3(1.0f), vec3(0, 0, -0.5f)), {}};
    scene.instances[3].mesh = 2;
    scene.materials = {leaf, veil, floor};
    scene.textures = {texture};
    finish_scene(scene);

    RandomStream random(11, RandomDomain::Test, 0, 0);
    std::vector<Ray> rays;
    while (rays.size() < 20000) {
        const Ray ray{{random.next(), random.next(), 3}, {0, 0, -1}, rays.size() % 2 ? kInfinity : 2.75f};
        // Not on the texels' border, nor on the diagonal, where it depends on the triangle who is asked.
        if (std::abs(ray.origin.x - 0.5f) > 1e-3f && std::abs(ray.origin.x - ray.origin.y) > 1e-3f) rays.push_back(ray);
    }
    MemoryBudget budget;
    Stats stats;
    const std::unique_ptr<Intersector> embree = make_embree_intersector(scene, budget, stats);
    const gpu::BvhData bvh = gpu::build_bvh(scene);
    const gpu::DeviceScene device_scene(gpu_device(), scene);
    const Twin twin("tests/gpu/bvh.comp", &device_scene.set(), device_scene.specialization());
    const std::vector<Answer> answers = twin.run<Answer>(rays.size(), {{"rays", rays}});
    size_t met[4] = {};
    for (size_t i = 0; i < rays.size(); ++i) {
        const Hit expected = embree->closest_hit(rays[i]), host = gpu::closest_hit(bvh, scene, rays[i]);
        ASSERT_EQ(answers[i].hit.instance, expected.instance);
        ASSERT_EQ(host.instance, expected.instance);
        ASSERT_EQ(answers[i].occluded != 0, expected.valid());
        ASSERT_EQ(gpu::occluded(bvh, scene, rays[i]), expected.valid());
        if (expected.valid()) ++met[expected.instance];
    }
    for (const size_t rays_met : met) EXPECT_GT(rays_met, 1000);
}

TEST(GpuBvh, IsTheSameEachTimeAndSmall) {
    const Scene scene = finished({triangle_soup(20000, 0.05f, 4)}, {{}});
    const gpu::BvhData once = gpu::build_bvh(scene), again = gpu::build_bvh(scene);
    ASSERT_EQ(once.bytes(), again.bytes());
    EXPECT_EQ(std::memcmp(once.nodes.data(), again.nodes.data(), once.nodes.size() * sizeof(gpu::BvhNode)), 0);
    EXPECT_EQ(
        std::memcmp(once.triangles.data(), again.triangles.data(), once.triangles.size() * sizeof(gpu::BvhTriangle)),
        0);
    EXPECT_LT(once.bytes(), 64u * 20000u);
    EXPECT_GT(once.bytes(), 48u * 20000u);
}

}  // namespace
}  // namespace photond::gpu_bvh_test
