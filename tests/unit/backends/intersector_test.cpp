// The ray interface against a loop over all triangles, for single rays and batches; alpha; instances; memory; threads.

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "protocol/error.h"
#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/core/rng.h"
#include "renderer/scene/scene.h"

namespace photond::intersector_test {
namespace {

/// Random triangles in the unit cube; `spread` is their size.
Mesh triangle_soup(uint32_t count, float spread, uint64_t seed) {
    RandomStream random(seed, RandomDomain::Test, 0, 0);
    const auto point = [&] { return vec3(random.next(), random.next(), random.next()); };
    Mesh mesh;
    for (uint32_t i = 0; i < count; ++i) {
        const vec3 centre = point();
        for (int c = 0; c < 3; ++c) mesh.positions.push_back(centre + spread * (point() - 0.5f));
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh;
}

std::vector<Ray> random_rays(size_t count, uint64_t seed) {
    RandomStream random(seed, RandomDomain::Test, 1, 0);
    const auto point = [&] { return vec3(random.next(), random.next(), random.next()); };
    std::vector<Ray> rays;
    while (rays.size() < count) {
        const vec3 d = point() - 0.5f;
        if (glm::length(d) < 0.01f) continue;
        rays.push_back({2.0f * point() - 0.5f, glm::normalize(d), random.next() < 0.5f ? kInfinity : random.next()});
    }
    return rays;
}

/// Moeller and Trumbore in double precision, over everything.
Hit brute_force(const Scene& scene, const Ray& ray) {
    Hit best;
    double nearest = ray.t_max;
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
        for (uint32_t k = 0; k < mesh.triangles.size(); ++k) {
            const TriangleCorners corners = world_triangle(scene, i, k);
            const dvec3 p(corners.p[0]), e1 = dvec3(corners.p[1]) - p, e2 = dvec3(corners.p[2]) - p, d(ray.direction);
            const dvec3 s = dvec3(ray.origin) - p, h = glm::cross(d, e2), q = glm::cross(s, e1);
            const double a = glm::dot(e1, h);
            const double u = glm::dot(s, h) / a, v = glm::dot(d, q) / a, t = glm::dot(e2, q) / a;
            if (!(u >= 0 && v >= 0 && u + v <= 1 && t > 0 && t < nearest)) continue;
            nearest = t;
            best = {float(t), i, k, float(u), float(v)};
        }
    }
    return best;
}

/// Rays so close to an edge that rounding may decide either way: few, counted, and left out of the comparison.
bool near_edge(const Scene& scene, const Ray& ray) {
    constexpr float kShift = 2e-5f;
    const Hit here = brute_force(scene, ray);
    for (int axis = 0; axis < 3; ++axis) {
        for (const float sign : {-kShift, kShift}) {
            Ray moved = ray;
            moved.origin[axis] += sign;
            const Hit there = brute_force(scene, moved);
            if (there.instance != here.instance || there.triangle != here.triangle) return true;
        }
    }
    return false;
}

Scene finished(std::vector<Mesh> meshes, std::vector<Instance> instances, std::vector<Material> materials = {{}}) {
    Scene scene;
    scene.meshes = std::move(meshes);
    scene.instances = std::move(instances);
    scene.materials = std::move(materials);
    finish_scene(scene);
    return scene;
}

std::unique_ptr<Intersector> build(const Scene& scene) {
    MemoryBudget budget;
    Stats stats;
    return make_embree_intersector(scene, budget, stats);
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

void expect_agrees_with_brute_force(const Scene& scene) {
    const std::unique_ptr<Intersector> intersector = build(scene);
    const std::vector<Ray> rays = random_rays(1003, 7);  // not a multiple of any packet's width
    std::vector<Hit> batch(rays.size());
    std::vector<uint8_t> occluded(rays.size());
    size_t skipped = 0, hits = 0;
    for (const Coherence coherence : {Coherence::Coherent, Coherence::Incoherent}) {
        intersector->closest_hits(rays, batch, coherence);
        intersector->occluded(rays, occluded, coherence);
        for (size_t i = 0; i < rays.size(); ++i) {
            if (near_edge(scene, rays[i])) {
                ++skipped;
                continue;
            }
            const Hit expected = brute_force(scene, rays[i]), single = intersector->closest_hit(rays[i]);
            for (const Hit& hit : {batch[i], single}) {
                ASSERT_EQ(hit.valid(), expected.valid()) << "ray " << i;
                if (!expected.valid()) continue;
                EXPECT_EQ(hit.instance, expected.instance);
                EXPECT_EQ(hit.triangle, expected.triangle);
                EXPECT_NEAR(hit.t, expected.t, 1e-5f);
                const TriangleCorners c = world_triangle(scene, hit.instance, hit.triangle);
                const vec3 p = (1 - hit.u - hit.v) * c.p[0] + hit.u * c.p[1] + hit.v * c.p[2];
                EXPECT_LT(glm::distance(p, rays[i].origin + hit.t * rays[i].direction), 1e-4f);
            }
            EXPECT_EQ(occluded[i] != 0, expected.valid());
            EXPECT_EQ(intersector->occluded(rays[i]), expected.valid());
            hits += expected.valid();
        }
    }
    EXPECT_LT(skipped, rays.size() / 10);
    EXPECT_GT(hits, rays.size() / 50);
}

TEST(Intersector, AgreesWithALoopOverAllTriangles) {
    for (const uint32_t count : {1u, 12u, 40u, 300u})
        expect_agrees_with_brute_force(finished({triangle_soup(count, count == 1 ? 3.0f : 0.7f, count)}, {{}}));
}

TEST(Intersector, PlacesInstancesMirroredOnesIncluded) {
    const mat3 turn(vec3(0, 0.5f, 0), vec3(-0.5f, 0, 0), vec3(0, 0, 0.5f)),
        mirror(vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1));
    expect_agrees_with_brute_force(
        finished({triangle_soup(20, 0.7f, 1), triangle_soup(30, 0.5f, 2)},
                 {placed(1, turn, vec3(0.5f, 0, 0)), {}, placed(1, mirror, vec3(1, 0.2f, 0))}));
}

TEST(Intersector, DoesNotTraceRaysWithoutLength) {
    const std::unique_ptr<Intersector> intersector = build(finished({triangle_soup(20, 1, 3)}, {{}}));
    std::vector<Ray> rays = random_rays(100, 5);
    for (size_t i = 0; i < rays.size(); ++i) rays[i].t_max = i % 2 ? 0.0f : -1.0f;
    std::vector<Hit> hits(rays.size(), Hit{1, 0, 0, 0, 0});
    std::vector<uint8_t> occluded(rays.size(), 1);
    intersector->closest_hits(rays, hits, Coherence::Incoherent);
    intersector->occluded(rays, occluded, Coherence::Incoherent);
    EXPECT_TRUE(std::none_of(hits.begin(), hits.end(), [](const Hit& hit) { return hit.valid(); }));
    EXPECT_EQ(std::count(occluded.begin(), occluded.end(), 0), 100);
    EXPECT_FALSE(intersector->closest_hit(rays[0]).valid());
    EXPECT_FALSE(intersector->occluded(rays[1]));
}

TEST(Intersector, EmptyScenesAreNeverHit) {
    const std::unique_ptr<Intersector> intersector = build(finished({}, {}));
    EXPECT_FALSE(intersector->closest_hit({vec3(0), vec3(1, 0, 0)}).valid());
    EXPECT_FALSE(intersector->occluded({vec3(0), vec3(1, 0, 0)}));
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

std::vector<Ray> rays_down(size_t count) {
    RandomStream random(11, RandomDomain::Test, 0, 0);
    std::vector<Ray> rays;
    for (size_t i = 0; i < count; ++i) rays.push_back({{random.next(), random.next(), 3}, {0, 0, -1}});
    return rays;
}

TEST(Intersector, BlendedSurfacesAreMetWithTheirAlphaAndAlwaysAlike) {
    Material veil, floor;
    veil.alpha_mode = AlphaMode::Blend;
    veil.alpha = 0.3f;
    for (const bool instanced : {false, true}) {
        Instance top = instanced ? placed(0, mat3(1.0f), vec3(0)) : Instance{};
        Instance bottom;
        bottom.mesh = 1;
        const Scene scene = finished({square(1, 0), square(0, 1)}, {top, bottom}, {veil, floor});
        const std::unique_ptr<Intersector> intersector = build(scene);
        constexpr size_t kRays = 20000;
        std::vector<Ray> rays = rays_down(kRays);
        std::vector<Hit> hits(kRays), again(kRays);
        intersector->closest_hits(rays, hits, Coherence::Coherent);
        intersector->closest_hits(rays, again, Coherence::Incoherent);
        size_t met = 0;
        for (size_t i = 0; i < kRays; ++i) {
            met += hits[i].instance == 0;
            EXPECT_EQ(hits[i].instance, again[i].instance);
            EXPECT_EQ(hits[i].instance, intersector->closest_hit(rays[i]).instance);
        }
        // Binomial; five standard deviations: false alarm 6e-7. A share off by 0.02 is found.
        EXPECT_NEAR(double(met) / kRays, 0.3, 5 * std::sqrt(0.3 * 0.7 / kRays));

        std::vector<uint8_t> occluded(kRays);
        for (Ray& ray : rays) ray.t_max = 2.5f;  // past the veil, short of the floor
        intersector->occluded(rays, occluded, Coherence::Incoherent);
        for (size_t i = 0; i < kRays; ++i) EXPECT_EQ(occluded[i] != 0, hits[i].instance == 0);
    }
}

TEST(Intersector, MaskedTexelsAreNoSurface) {
    Texture texture;  // left half cut away
    texture.size = {2, 1};
    texture.texels = {{255, 255, 255, 0}, {255, 255, 255, 255}};
    texture.nearest = true;
    Material leaf;
    leaf.alpha_mode = AlphaMode::Mask;
    leaf.base_color_texture.texture = 0;
    Scene scene;
    scene.meshes = {square(1, 0)};
    scene.instances = {{}};
    scene.materials = {leaf};
    scene.textures = {texture};
    finish_scene(scene);
    const std::unique_ptr<Intersector> intersector = build(scene);
    for (const Ray& ray : rays_down(1000)) {
        if (std::abs(ray.origin.x - 0.5f) < 1e-3f) continue;
        EXPECT_EQ(intersector->closest_hit(ray).valid(), ray.origin.x > 0.5f);
        EXPECT_EQ(intersector->occluded(ray), ray.origin.x > 0.5f);
    }
}

TEST(Intersector, AClosedSurfaceDoesNotLeak) {
    // A box seen from within, rays aimed at its edges, corners and the diagonals of its faces.
    Mesh box;
    for (int i = 0; i < 8; ++i) box.positions.push_back(vec3(i & 1, i >> 1 & 1, i >> 2 & 1) * 2.0f - 1.0f);
    for (const uvec3& t :
         {uvec3(0, 1, 3), uvec3(0, 3, 2), uvec3(4, 6, 7), uvec3(4, 7, 5), uvec3(0, 4, 5), uvec3(0, 5, 1),
          uvec3(2, 3, 7), uvec3(2, 7, 6), uvec3(0, 2, 6), uvec3(0, 6, 4), uvec3(1, 5, 7), uvec3(1, 7, 3)})
        box.triangles.push_back(t);
    RandomStream random(5, RandomDomain::Test, 0, 0);
    std::vector<Ray> rays;
    for (int i = 0; i < 100000; ++i) {
        const uvec3& t = box.triangles[random.next_bits() % box.triangles.size()];
        const uint32_t side = random.next_bits() % 3;
        const vec3 target = glm::mix(box.positions[t[int(side)]], box.positions[t[int((side + 1) % 3)]], random.next());
        const vec3 origin = 1.6f * vec3(random.next() - 0.5f, random.next() - 0.5f, random.next() - 0.5f);
        rays.push_back({origin, glm::normalize(target - origin)});
    }
    std::vector<Hit> hits(rays.size());
    // Alone, and beside so many triangles (out of reach of the rays) that the scene is no small one any more.
    Instance far_away = placed(1, mat3(1.0f), vec3(100));
    for (const Scene& scene : {finished({box}, {{}}), finished({box, triangle_soup(200, 0.3f, 2)}, {{}, far_away})}) {
        const std::unique_ptr<Intersector> intersector = build(scene);
        for (const Coherence coherence : {Coherence::Coherent, Coherence::Incoherent}) {
            intersector->closest_hits(rays, hits, coherence);
            EXPECT_EQ(std::count_if(hits.begin(), hits.end(), [](const Hit& hit) { return hit.instance != 0; }), 0);
        }
    }
}

TEST(Intersector, AnswersManyThreadsAlike) {
    const std::unique_ptr<Intersector> intersector = build(finished({triangle_soup(500, 0.3f, 9)}, {{}}));
    const std::vector<Ray> rays = random_rays(512, 3);
    std::vector<Hit> expected(rays.size());
    intersector->closest_hits(rays, expected, Coherence::Incoherent);
    std::atomic<int> different{0};
    tbb::parallel_for(0, 64, [&](int) {
        std::vector<Hit> hits(rays.size());
        intersector->closest_hits(rays, hits, Coherence::Incoherent);
        for (size_t i = 0; i < rays.size(); ++i)
            different += hits[i].instance != expected[i].instance || hits[i].t != expected[i].t;
    });
    EXPECT_EQ(different, 0);
}

TEST(Intersector, TakesWhatItBegan) {
    const std::unique_ptr<Intersector> intersector = build(finished({triangle_soup(500, 0.3f, 9)}, {{}}));
    for (const size_t count : {0, 1, 9000}) {
        const std::vector<Ray> rays = random_rays(count, 3);
        std::vector<Hit> expected(rays.size());
        intersector->closest_hits(rays, expected, Coherence::Incoherent);
        const std::vector<Hit> taken = intersector->begin_closest_hits(rays, Coherence::Incoherent)->take();
        ASSERT_EQ(taken.size(), count);
        for (size_t i = 0; i < count; ++i) {
            ASSERT_EQ(taken[i].instance, expected[i].instance);
            ASSERT_EQ(taken[i].t, expected[i].t);
        }
    }
}

TEST(Intersector, CountsItsBytesAndKeepsToTheBudget) {
    const Scene scene = finished({triangle_soup(20000, 0.1f, 4)}, {{}});
    Stats stats;
    MemoryBudget roomy;
    const uint64_t bytes = make_embree_intersector(scene, roomy, stats)->bytes();
    EXPECT_GT(bytes, 20000u * 30);   // less than this holds no 20,000 triangles
    EXPECT_LT(bytes, 20000u * 600);  // more than this is a leak
    EXPECT_EQ(roomy.structures().at("acceleration"), bytes);
    EXPECT_GE(stats.stage("acceleration_build").wall_seconds, 0);

    MemoryBudget tight(bytes / 2);
    try {
        make_embree_intersector(scene, tight, stats);
        FAIL() << "half of the memory was enough";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::OutOfMemory);
    }
}

}  // namespace
}  // namespace photond::intersector_test
