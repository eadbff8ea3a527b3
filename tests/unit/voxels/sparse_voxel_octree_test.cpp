// The octree against the triangles it is made of: what is in it, and what rays meet in it.

#include "renderer/voxels/sparse_voxel_octree.h"

#include <gtest/gtest.h>

#include <cstring>

#include "renderer/scene/builtin_scenes.h"
#include "renderer/voxels/triangle_voxels.h"
#include "tests/support/threads.h"
#include "tests/support/voxels.h"

namespace photond::sparse_voxel_octree_test {
namespace {

using test::VoxelList;

Scene scene_named(const std::string& name) {
    return name == "medley" ? test::voxel_medley() : make_builtin_scene(name);
}

SparseVoxelOctree build(const Scene& scene, uint32_t resolution, bool surfaces = true) {
    return {scene, make_voxel_grid(scene.bounds, resolution), surfaces};
}

/// Every brick of the grid asked about every triangle.
VoxelList brute_force(const Scene& scene, const gpu::SvoConstants& constants) {
    const auto n = static_cast<int32_t>(constants.grid.resolution), bricks = n / BRICK_SIDE;
    std::vector<uint32_t> least(static_cast<size_t>(n * n * n), ~0u);
    uint32_t number = 0;
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        for (uint32_t t = 0; t < scene.meshes[scene.instances[i].mesh].triangles.size(); ++t, ++number) {
            const TriangleVoxels triangle(quantised_triangle(constants, scene, i, t), bricks);
            for (int32_t b = 0; b < bricks * bricks * bricks; ++b) {
                const glm::ivec3 brick(b % bricks, b / bricks % bricks, b / bricks / bricks);
                const uint64_t mask = triangle.brick_mask(brick);
                for (int bit = 0; bit < 64; ++bit) {
                    if (!(mask >> bit & 1)) continue;
                    const glm::ivec3 v = BRICK_SIDE * brick + glm::ivec3(bit & 3, bit >> 2 & 3, bit >> 4);
                    uint32_t& triangle_there = least[static_cast<size_t>(v.x + n * (v.y + n * v.z))];
                    triangle_there = std::min(triangle_there, number);
                }
            }
        }
    }
    VoxelList list;
    for (size_t v = 0; v < least.size(); ++v)
        if (least[v] != ~0u) list.voxels.push_back(v), list.triangles.push_back(least[v]);
    return list;
}

class Octree : public testing::TestWithParam<const char*> {};

TEST_P(Octree, HoldsTheTrianglesVoxelsAndNoOthers) {
    const Scene scene = scene_named(GetParam());
    for (const uint32_t resolution : {16u, 32u}) {
        const SparseVoxelOctree tree = build(scene, resolution);
        const VoxelList list = test::list_voxels(tree.view());
        EXPECT_EQ(list, brute_force(scene, tree.constants()));
        EXPECT_EQ(list.voxels.size(), tree.voxel_count());
    }
}

TEST_P(Octree, HasRandomPointsOfAllTrianglesInIt) {
    const Scene scene = scene_named(GetParam());
    RandomStream random(1, RandomDomain::Test, 0, 0);
    for (const uint32_t resolution : {64u, 512u}) {
        const SparseVoxelOctree tree = build(scene, resolution);
        const gpu::SvoConstants& constants = tree.constants();
        for (uint32_t i = 0; i < scene.instances.size(); ++i) {
            const size_t triangles = scene.meshes[scene.instances[i].mesh].triangles.size();
            const int points = static_cast<int>(200'000 / scene.triangle_count) + 4;
            for (uint32_t t = 0; t < triangles; ++t) {
                const TriangleCorners c = world_triangle(scene, i, t);
                for (int k = 0; k < points; ++k) {
                    const vec2 u = random.next_2d();
                    const double root = std::sqrt(double{u.x}), v = u.y;
                    const dvec3 p =
                        (1 - root) * dvec3(c.p[0]) + root * (1 - v) * dvec3(c.p[1]) + root * v * dvec3(c.p[2]);
                    const uvec3 voxel((p - dvec3(constants.grid.low)) / double{constants.grid.cell_m});
                    ASSERT_TRUE(tree.view().is_set(voxel)) << resolution << ": " << i << ", " << t;
                }
            }
        }
    }
}

TEST_P(Octree, IsLaidOutAsTheThesisHasIt) {
    const Scene scene = scene_named(GetParam());
    const SparseVoxelOctree tree = build(scene, 64, false);
    const SvoView view = tree.view();
    EXPECT_TRUE(view.surfaces.empty());
    EXPECT_EQ(view.nodes.size() % 8, 0u);
    size_t tiles = 1, bricks = 0;
    for (const gpu::SvoNode& node : view.nodes) {
        const bool flagged = node.info & SVO_FLAGGED, leaf = node.info & SVO_LEAF;
        const uvec3 low(node.low & 1023, node.low >> 10 & 1023, node.low >> 20);
        const uvec3 high(node.high & 1023, node.high >> 10 & 1023, node.high >> 20);
        EXPECT_EQ(high - low, uvec3(high.x - low.x));
        EXPECT_TRUE(flagged || leaf);
        if (leaf) {
            EXPECT_EQ(node.data, flagged ? bricks++ : SVO_NO_DATA);
            continue;
        }
        EXPECT_EQ(node.info & SVO_TILE_MASK, tiles++);  // level after level
        const gpu::SvoNode* children = &view.nodes[size_t{node.info & SVO_TILE_MASK} * 8];
        EXPECT_EQ(children[0].low, node.low);
        EXPECT_EQ(children[7].high, node.high);
    }
    EXPECT_EQ(tiles * 8, view.nodes.size());
    EXPECT_EQ(bricks, view.bricks.size());
}

/// Of cells chosen at random: the cube they may be left by is free, and by one larger it would not be.
TEST_P(Octree, KnowsTheLargestFreeCubes) {
    for (const uint32_t resolution : {32u, 512u}) {
        const SparseVoxelOctree tree = build(scene_named(GetParam()), resolution, false);
        const SvoCells& cells = *tree.view().cells;
        EXPECT_EQ(cells.bytes(), SvoCells::estimate_bytes(resolution) + 1);
        const int n = 1 << cells.bits;
        EXPECT_EQ(static_cast<uint32_t>(n) << cells.shift, resolution);
        std::vector<uint8_t> full(cells.plane());
        for (const uint64_t v : test::list_voxels(tree.view()).voxels) {
            const uvec3 at =
                uvec3(v % resolution, v / resolution % resolution, v / resolution / resolution) >> cells.shift;
            full[at.x | at.y << cells.bits | at.z << 2 * cells.bits] = 1;
        }
        RandomStream random(6, RandomDomain::Test, 0, 0);
        size_t free_cells = 0;
        for (int i = 0; i < 500; ++i) {
            const glm::ivec3 cell(test::random_vec3(random) * static_cast<float>(n));
            const uint32_t octant = random.next_bits() % 8;
            const auto is_free = [&](int cube) {
                int first[3], last[3];  // what of the cube lies within the grid
                for (int axis = 0; axis < 3; ++axis) {
                    const bool down = octant >> axis & 1;
                    first[axis] = std::max(0, down ? cell[axis] - cube + 1 : cell[axis]);
                    last[axis] = std::min(n - 1, down ? cell[axis] : cell[axis] + cube - 1);
                }
                for (int z = first[2]; z <= last[2]; ++z)
                    for (int y = first[1]; y <= last[1]; ++y)
                        for (int x = first[0]; x <= last[0]; ++x)
                            if (full[static_cast<size_t>(x | y << cells.bits | z << 2 * cells.bits)]) return false;
                return true;
            };
            const uvec3 place(cell);
            const int cube = cells.free_cubes(octant)[place.x | place.y << cells.bits | place.z << 2 * cells.bits];
            EXPECT_TRUE(is_free(cube));
            EXPECT_TRUE(cube >= n || !is_free(cube + 1));
            free_cells += cube > 0;
        }
        EXPECT_GT(free_cells, 50u);
    }
}

TEST_P(Octree, IsTheSameHoweverManyThreadsBuildIt) {
    const Scene scene = scene_named(GetParam());
    const auto one = test::on_threads(1, [&] { return build(scene, 256); });
    const auto four = test::on_threads(4, [&] { return build(scene, 256); });
    const auto same = [](const auto& a, const auto& b) {
        return a.size_bytes() == b.size_bytes() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
    };
    EXPECT_TRUE(same(one.view().nodes, four.view().nodes));
    EXPECT_TRUE(same(one.view().bricks, four.view().bricks));
    EXPECT_TRUE(same(one.view().surfaces, four.view().surfaces));
}

TEST_P(Octree, TakesTheBytesItWasExpectedTo) {
    const Scene scene = scene_named(GetParam());
    for (const uint32_t resolution : {64u, 256u}) {
        for (const bool surfaces : {false, true}) {
            const VoxelGrid grid = make_voxel_grid(scene.bounds, resolution);
            const double real = double(SparseVoxelOctree(scene, grid, surfaces).bytes());
            const double expected = double(SparseVoxelOctree::estimate_bytes(scene, grid, surfaces));
            EXPECT_LT(real, 2 * expected) << resolution;
            EXPECT_GT(real, expected / 2) << resolution;
        }
    }
}
INSTANTIATE_TEST_SUITE_P(Scenes, Octree, testing::Values("medley", "cornell-box", "photon-splatting/chairs"));

TEST(SparseVoxelOctree, OfAnEmptySceneIsOneTile) {
    Scene scene;
    finish_scene(scene);
    const SparseVoxelOctree tree = build(scene, 128);
    EXPECT_EQ(tree.view().nodes.size(), 8u);
    EXPECT_EQ(tree.voxel_count(), 0u);
    VoxelHit hit;
    EXPECT_FALSE(svo_first_voxel(tree.view(), {vec3(0), vec3(0, 0, 1)}, hit));
    EXPECT_FALSE(svo_occluded(tree.view(), vec3(-1), vec3(1)));
}

TEST(SparseVoxelOctree, LeavesOutWhatHardlyStopsLight) {
    for (const auto& [mode, alpha, solid] : {std::tuple(AlphaMode::Mask, 1.0f, true),
                                             {AlphaMode::Mask, 0.3f, false},
                                             {AlphaMode::Blend, 0.8f, true},
                                             {AlphaMode::Blend, 0.2f, false},
                                             {AlphaMode::Opaque, 0.0f, true}}) {
        Scene scene;
        Material material = test::lambert(0.5f);
        material.alpha_mode = mode;
        material.alpha = alpha;
        test::add(scene, MeshBuilder().quad(vec3(0), vec3(1, 0, 0), vec3(1, 1, 0), vec3(0, 1, 0)).build(0), material);
        finish_scene(scene);
        EXPECT_EQ(build(scene, 16).voxel_count() > 0, solid);
    }
}

/// Scaling a scene, or moving it, moves its voxels along.
TEST(SparseVoxelOctree, IsTheSameOfHugeTinyAndFarScenes) {
    const auto moved = [](float scale, float offset) {
        Scene scene = make_builtin_scene("cornell-box");
        for (Mesh& mesh : scene.meshes)
            for (vec3& p : mesh.positions) p = scale * p + offset;
        for (Instance& instance : scene.instances) EXPECT_TRUE(instance.identity);
        scene.triangle_lights.clear();
        finish_scene(scene);
        return scene;
    };
    const VoxelList at_home = test::list_voxels(build(moved(1, 0), 64).view());
    for (const float scale : {0x1p-40f, 0x1p-10f, 0x1p10f, 0x1p40f})
        EXPECT_EQ(test::list_voxels(build(moved(scale, 0), 64).view()), at_home) << scale;
    // Far away coordinates are coarse: some triangle on a voxel's border changes sides.
    const Scene far = moved(1, 1000);
    const double count = double(build(far, 64).voxel_count());
    EXPECT_NEAR(count / double(at_home.voxels.size()), 1, 0.05);
}

// 64 MB are allowed for Sponza at 512^3, whose surfaces are in 2.26 million voxels (photond-gpu-bench --only octree).
TEST(SparseVoxelOctree, OfAFurnishedRoomAt512TakesLessThanHalfOfWhatIsAllowedAVoxel) {
    constexpr double kAllowedBytesAVoxel = 64e6 / 2.26e6;
    const Scene scene = scene_named("interior");
    const SparseVoxelOctree tree = build(scene, 512);
    const auto bytes = double(tree.bytes()), voxels = double(tree.voxel_count());
    EXPECT_GT(voxels, 1e5);
    EXPECT_LT(bytes / voxels, kAllowedBytesAVoxel / 2);
    const double expected = double(SparseVoxelOctree::estimate_bytes(scene, tree.constants().grid, true));
    EXPECT_LT(bytes, 2 * expected);
    EXPECT_GT(bytes, expected / 2);
    std::printf("%.1f MB, %.2f bytes a voxel, expected %.1f MB\n", 1e-6 * bytes, bytes / voxels, 1e-6 * expected);
}

}  // namespace
}  // namespace photond::sparse_voxel_octree_test
