// Rays that leave a surface do not meet it again, and do not start far from it.

#include <gtest/gtest.h>

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/core/rng.h"
#include "renderer/transport/sampling.h"
#include "renderer/transport/surface.h"

namespace photond::ray_origin_test {
namespace {

constexpr int kTriangles = 40, kPoints = 50;

vec3 direction_from(RandomStream& random) {
    return Frame(vec3(0, 0, 1)).to_world(sample_cosine_hemisphere({random.next(), random.next()})) *
           (random.next() < 0.5f ? -1.0f : 1.0f);
}

/// A triangle of that size whose centre is near `centre`, seven others of its like far off, and, so that the scene is
/// no small one, a hundred tiny ones beside them.
Scene scene_of(float size, const vec3& centre, RandomStream& random) {
    Scene scene;
    scene.materials.resize(1);
    const auto add = [&](const vec3& at, float extent) {
        const vec3 a = direction_from(random), b = glm::normalize(glm::cross(a, direction_from(random)));
        Mesh mesh;
        for (int i = 0; i < 3; ++i) {
            const float angle = 2 * kPi / 3 * static_cast<float>(i);
            mesh.positions.push_back(at + extent * (std::cos(angle) * a + std::sin(angle) * b));
        }
        mesh.triangles.emplace_back(0, 1, 2);
        Instance instance;
        instance.mesh = static_cast<uint32_t>(scene.meshes.size());
        scene.meshes.push_back(std::move(mesh));
        scene.instances.push_back(instance);
    };
    add(centre, size);
    for (int i = 0; i < 100; ++i) add(centre + 1000 * size * vec3(1 + random.next(), 1, 1), 0.01f * size);
    finish_scene(scene);
    return scene;
}

struct Found {
    int rays = 0, met_again = 0;
    float farthest = 0;  // start from the point's plane, of the triangle's size
};

/// Rays to both sides of points within `spread` of the triangle's centre, half of them grazing it.
Found leave(float size, float distance, float spread) {
    RandomStream random(7, RandomDomain::Test, 0, 0);
    Found found;
    for (int k = 0; k < kTriangles; ++k) {
        const vec3 centre = distance > 0 ? distance * direction_from(random) : 0.01f * size * direction_from(random);
        const Scene scene = scene_of(size, distance > 0 ? centre : spread * direction_from(random), random);
        MemoryBudget budget;
        Stats stats;
        const auto intersector = make_embree_intersector(scene, budget, stats);
        for (int i = 0; i < kPoints; ++i) {
            const float reach = 0.3f * std::min(1.0f, spread / size);
            const Hit hit{1, 0, 0, 1.0f / 3 + reach * (random.next() - 0.5f),
                          1.0f / 3 + reach * (random.next() - 0.5f)};
            const ShadingPoint point = make_plain_shading_point(scene, hit, direction_from(random));
            for (int r = 0; r < 4; ++r) {
                vec3 w = direction_from(random);
                if (r % 2) w = glm::normalize(w - 0.99f * glm::dot(w, point.geometric_normal) * point.geometric_normal);
                const Ray ray{ray_origin(point, w), w, kInfinity};
                const Hit again = intersector->closest_hit(ray);
                found.met_again += again.valid() && again.instance == 0;
                ++found.rays;
                found.farthest = std::max(found.farthest, glm::distance(ray.origin, point.position) / size);
            }
        }
    }
    return found;
}

TEST(RayOrigin, NearTheOriginLargeTrianglesAreNotMetAgain) {
    // 37 % of such rays met a triangle of 1000 m again where their start was moved by the point's own rounding.
    for (const float size : {1.0f, 1e2f, 1e3f, 1e5f}) {
        const Found found = leave(size, 0, std::min(size, 1.0f));
        EXPECT_EQ(found.met_again, 0) << size << " m";
        EXPECT_GE(found.rays, 8000);
        EXPECT_LT(found.farthest, 2e-5f);
    }
}

TEST(RayOrigin, FarFromTheOriginTheStepIsThatOfTheCoordinates) {
    for (const float distance : {1.0f, 1e2f, 1e4f, 1e5f}) {
        const Found found = leave(1, distance, 1);
        EXPECT_EQ(found.met_again, 0) << distance << " m";
        EXPECT_LT(found.farthest, 2e-5f * (distance + 1));
    }
}

TEST(RayOrigin, InATinySceneTheStepIsTiny) {
    for (const float size : {1e-2f, 1e-4f, 1e-6f}) {
        const Found found = leave(size, 0, size);
        EXPECT_EQ(found.met_again, 0) << size << " m";
        EXPECT_LT(found.farthest, 2e-5f) << "of the triangle's size";
    }
}

}  // namespace
}  // namespace photond::ray_origin_test
