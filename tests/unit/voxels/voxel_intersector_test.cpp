// Rays through voxels instead of triangles: hits no further from the truth than the stated bias.

#include "renderer/voxels/voxel_intersector.h"

#include <gtest/gtest.h>

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/transport/sampling.h"
#include "tests/support/voxels.h"

namespace photond::voxel_intersector_test {
namespace {

struct Both {
    explicit Both(Scene made, uint32_t resolution)
        : scene(std::move(made)), tree(scene, make_voxel_grid(scene.bounds, resolution), true), voxels(scene, tree) {
        MemoryBudget budget;
        Stats stats;
        rays = make_embree_intersector(scene, budget, stats);
    }
    float cell_m() const { return tree.constants().grid.cell_m; }

    const Scene scene;
    const SparseVoxelOctree tree;
    const VoxelIntersector voxels;
    std::unique_ptr<Intersector> rays;
};

vec3 hit_point(const Scene& scene, const Hit& hit) {
    const TriangleCorners c = world_triangle(scene, hit.instance, hit.triangle);
    return (1 - hit.u - hit.v) * c.p[0] + hit.u * c.p[1] + hit.v * c.p[2];
}

Scene empty_box() {
    Scene scene;
    test::add(scene, MeshBuilder().box(vec3(-1), vec3(1)).build(0), test::lambert(0.5f));
    finish_scene(scene);
    return test::turned(scene);
}

/// In an empty convex room the planes are right: away from its edges hits are exact, and nothing blocks any segment.
TEST(VoxelIntersector, IsExactAwayFromEdges) {
    const Both both(empty_box(), 128);
    RandomStream random(1, RandomDomain::Test, 0, 0);
    const Ray from_centre{vec3(0), vec3(0, 0, 1)};
    int compared = 0, wrong = 0, escaped = 0, blocked = 0, other_half = 0;
    for (int i = 0; i < 20'000; ++i) {
        // From the middle of a face, to wherever the bounce goes.
        const vec3 d = glm::normalize(test::random_vec3(random) - 0.5f);
        const Hit start = both.rays->closest_hit({from_centre.origin, d});
        const TriangleCorners c = world_triangle(both.scene, start.instance, start.triangle);
        vec3 n = glm::normalize(glm::cross(c.p[1] - c.p[0], c.p[2] - c.p[0]));
        if (glm::dot(n, d) > 0) n = -n;
        const vec3 p = hit_point(both.scene, start);
        const vec3 w = Frame(n).to_world(sample_cosine_hemisphere(random.next_2d()));
        const Ray ray{p, w};
        const Hit real = both.rays->closest_hit({offset_ray_origin(p, n), w});
        const Hit voxel = both.voxels.closest_hit(ray);
        escaped += !voxel.valid();
        if (!voxel.valid()) continue;
        const vec3 q = hit_point(both.scene, real);
        const auto near_edge = [&](const vec3& x) {
            const mat3 turn(glm::rotate(mat4(1.0f), 0.7f, glm::normalize(vec3(1, 2, 3))));  // as test::turned()
            const vec3 at = glm::abs(glm::transpose(turn) * x), inside = glm::vec3(1) - at;
            return (inside.x < 6 * both.cell_m()) + (inside.y < 6 * both.cell_m()) + (inside.z < 6 * both.cell_m()) > 1;
        };
        if (near_edge(p) || near_edge(q)) continue;
        blocked += both.voxels.occluded({p, q - p, 1});
        // Along flatter rays the hit is cut to the lifted ray's.
        const TriangleCorners met = world_triangle(both.scene, real.instance, real.triangle);
        if (std::fabs(glm::dot(glm::normalize(glm::cross(met.p[1] - met.p[0], met.p[2] - met.p[0])), w)) < 0.26f)
            continue;
        ++compared;
        // The rays start 256 spacings of floats apart. Along the face's diagonal the other triangle has the voxels, and
        // the hit is cut to it.
        const float off = glm::distance(hit_point(both.scene, voxel), q);
        other_half += voxel.triangle != real.triangle;
        wrong += off > (voxel.triangle == real.triangle ? 0.01f : 8.0f) * both.cell_m();
    }
    EXPECT_GT(compared, 10'000);
    EXPECT_EQ(wrong, 0);
    EXPECT_LT(other_half, compared / 10);
    EXPECT_LE(blocked, 4);
    EXPECT_LE(escaped, 4);  // that start on an edge, to a hundredth of a voxel, and are taken for its other face's
}

class VoxelIntersectors : public testing::TestWithParam<const char*> {};

TEST_P(VoxelIntersectors, HitNearWhereRaysDo) {
    int far_at_64 = 0;
    float far_m = 0;  // three voxels of the coarser grid
    for (const uint32_t resolution : {64u, 256u}) {
        const Both both(make_builtin_scene(GetParam()), resolution);
        if (resolution == 64) far_m = 3 * both.cell_m();
        RandomStream random(2, RandomDomain::Test, 0, 0);
        int rays = 0, far = 0, both_hit = 0;
        for (int i = 0; i < 20'000; ++i) {
            const vec3 size = both.scene.bounds.diagonal();
            const vec3 from = both.scene.bounds.min + (0.8f * test::random_vec3(random) + 0.1f) * size;
            const Ray ray{from, glm::normalize(test::random_vec3(random) - 0.5f)};
            const Hit real = both.rays->closest_hit(ray), voxel = both.voxels.closest_hit(ray);
            ++rays;
            if (real.t < 0.02f * both.cell_m()) continue;  // is taken for one that leaves the surface
            if (real.valid()) {
                ASSERT_TRUE(voxel.valid());  // conservative
            }
            if (!real.valid() || !voxel.valid()) continue;
            ++both_hit;
            far += glm::distance(hit_point(both.scene, real), hit_point(both.scene, voxel)) > far_m;
            ASSERT_GE(voxel.u, 0);
            ASSERT_GE(voxel.v, 0);
            ASSERT_LE(voxel.u + voxel.v, 1.0001f);
            ASSERT_GT(voxel.t, 0);
        }
        EXPECT_GT(both_hit, rays / 2);
        // Those that pass a silhouette within a voxel or so: the fewer, the smaller the voxels.
        if (resolution == 64)
            far_at_64 = far;
        else
            EXPECT_LT(far, 0.6 * far_at_64);
        EXPECT_LT(far, 0.35 * rays) << resolution;
        EXPECT_GT(far, 0);
    }
}
INSTANTIATE_TEST_SUITE_P(Scenes, VoxelIntersectors,
                         testing::Values("cornell-box", "photon-splatting/chairs", "interior"));

TEST(VoxelIntersector, AnswersBatchesAsSingleRaysAndEndsThemAtTheirEnd) {
    const Both both(make_builtin_scene("cornell-box"), 64);
    RandomStream random(3, RandomDomain::Test, 0, 0);
    std::vector<Ray> rays;
    for (int i = 0; i < 2000; ++i)
        rays.push_back({both.scene.bounds.centre(), test::random_vec3(random) - 0.5f, 2 * random.next()});
    rays.push_back({vec3(0.1f), vec3(0, 0, 1), 0});
    rays.push_back({vec3(0.1f), vec3(0), 1});
    rays.push_back({vec3(std::nanf("")), vec3(1, 0, 0), 1});
    std::vector<Hit> hits(rays.size());
    std::vector<uint8_t> occluded(rays.size());
    both.voxels.closest_hits(rays, hits, Coherence::Incoherent);
    both.voxels.occluded(rays, occluded, Coherence::Incoherent);
    int met = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
        const Hit hit = both.voxels.closest_hit(rays[i]);
        EXPECT_EQ(hit.t, hits[i].t);
        EXPECT_EQ(hit.triangle, hits[i].triangle);
        EXPECT_EQ(both.voxels.occluded(rays[i]), occluded[i] != 0);
        EXPECT_TRUE(!hit.valid() || hit.t < rays[i].t_max);
        met += hit.valid();
    }
    EXPECT_GT(met, 200);
    EXPECT_LT(met, 1900);
    for (size_t i = 2000; i < rays.size(); ++i) EXPECT_FALSE(hits[i].valid() || occluded[i]);
}

}  // namespace
}  // namespace photond::voxel_intersector_test
