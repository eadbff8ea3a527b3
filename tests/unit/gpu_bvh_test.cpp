// The device's ray structure: the host's traversal of it against Embree, the device's against the host's.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/backends/gpu/bvh.h"
#include "renderer/backends/gpu/scene_bindings.h"
#include "renderer/core/rng.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/scene.h"
#include "tests/support/gpu_twin.h"

namespace photond {
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

std::vector<Answer> device_answers(const gpu::BvhData& bvh, const Scene& scene, const std::vector<Ray>& rays) {
    const PartOfScene part({{BVH_NODES_BINDING, std::as_bytes(std::span(bvh.nodes))},
                            {BVH_TRIANGLES_BINDING, std::as_bytes(std::span(bvh.triangles))}});
    const Twin twin("tests/gpu/bvh.comp", &part.set(),
                    {gpu::specialize(0, scene.needs.instances), gpu::specialize(1, false)});
    return twin.run<Answer>(rays.size(), {rays});
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

Differences differences(const Scene& scene, const std::vector<Ray>& rays) {
    const gpu::BvhData bvh = gpu::build_bvh(scene);
    MemoryBudget budget;
    Stats stats;
    const std::unique_ptr<Intersector> embree = make_embree_intersector(scene, budget, stats);
    const std::vector<Answer> answers = device_answers(bvh, scene, rays);
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
    ASSERT_TRUE(scene.needs.instances);
    const std::vector<Ray> rays = random_rays({vec3(-1), vec3(2)}, 8001, 7);
    const Differences found = differences(scene, rays);
    EXPECT_LE(found.embree, 4);
    EXPECT_LE(found.device, 4);
    EXPECT_EQ(found.occlusion, 0);
    EXPECT_GT(found.hits, rays.size() / 10);
}

}  // namespace
}  // namespace photond
